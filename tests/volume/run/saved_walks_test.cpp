#include "volume/run/saved_walks.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cstring>

#include "phase/random/lattice.h"
#include "phase/stack/builtin_stacks.h"
#include "tests/volume/run/draw.h"
#include "tests/volume/run/stacks.h"
#include "volume/result/number_bytes.h"

namespace lamella {
namespace {

using testing::Draw;
using testing::every_medium;
using testing::layer;
using testing::stack_from;

// Everything of a batch, bit by bit; events of thinned walks are counted for several batches
// together, so that their sum counts.
std::string bits_of(const Simulation& simulation) {
  NumberWriter out;
  for (const BatchTally& b : simulation.batches()) {
    out.put(b.walks);
    out.put(b.holes);
    const auto* energies = reinterpret_cast<const double*>(&b.energy);
    out.put_all(std::span(energies, sizeof(EnergySums) / sizeof(double)));
    out.put_all(std::span<const double>(b.f));
  }
  out.put(simulation.walks());
  out.put(simulation.collisions());
  return out.take();
}

template <class F>
auto on_threads(int threads, const F& f) {
  const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
  tbb::task_arena arena(threads);
  return arena.execute(f);
}

struct Case {
  Stack stack;
  Plan plan;
  Direction incident;
  Estimator estimator;
  std::uint64_t walks, seed;

  [[nodiscard]] std::unique_ptr<Simulation> simulation() const {
    return std::make_unique<Simulation>(stack, plan, incident, estimator, CellGrid{3, 4, false},
                                        seed);
  }
};

// One to three layers, an interface at times, a substrate at times; on lanes or not.
Case drawn(Draw& draw) {
  std::string text;
  const std::size_t layers = 1 + draw.below(3);
  for (std::size_t k = 0; k < layers; ++k) {
    if (draw.below(6) == 0) text += layer("interface = 'smooth'\nior = 1.4");
    text += layer(fmt::format(
        "{}\nalbedo = {}\nthickness = {}", every_medium()[draw.below(every_medium().size())],
        draw.below(2) ? std::string("[0.9, 0.5, 1]") : fmt::format("{:g}", draw.rounded(0, 1)),
        draw.rounded(0, 3)));
  }
  if (draw.below(2)) text += "[substrate]\nbsdf = 'lambert'\nalbedo = 0.7\n";
  Case c{stack_from(text),
         {},
         direction_from_degrees(draw.rounded(0, 89), draw.rounded(0, 360)),
         draw.below(2) ? Estimator::analog : Estimator::next_event,
         kBatches + draw.below(2000),
         draw.below(1000)};
  c.plan = make_plan(c.stack, {.max_order = 500});
  const auto isas = supported_isas();
  c.plan.isa = isas[draw.below(isas.size())];
  SCOPED_TRACE(text);
  return c;
}

TEST(SavedWalks, OfAnyNumberOfPartsAreThoseOfTheWholeRun) {
  Draw draw{RandomStream(1, 2, StreamPurpose::measure)};
  for (int k = 0; k < 40; ++k) {
    const Case c = drawn(draw);
    const auto whole = c.simulation();
    on_threads(2, [&] { whole->advance(c.walks); });
    const int parts = 1 + static_cast<int>(draw.below(17));
    std::vector<std::string> saved;
    for (int p = 0; p < parts; ++p) {
      const int threads = std::array{1, 2, 7}[draw.below(3)];
      const auto part = c.simulation();
      part->walk_only({p * kBatches / parts, (p + 1) * kBatches / parts});
      on_threads(threads, [&] {
        part->advance(c.walks / 3);
        part->advance(c.walks);
      });
      saved.push_back(save_walks(*part, 0.5, true));
    }
    const auto merged = c.simulation();
    std::vector<bool> there;
    for (std::size_t p = saved.size(); p-- > 0;) {
      const SavedWalks found = restore_walks(saved[p], *merged, there);
      EXPECT_TRUE(found.done);
      EXPECT_EQ(found.seconds, 0.5);
    }
    EXPECT_EQ(std::count(there.begin(), there.end(), true), kBatches);
    ASSERT_EQ(bits_of(*merged), bits_of(*whole)) << to_toml(c.stack) << parts << " parts";
  }
}

// Walks through grids on lattices, of which a batch begins another every 16384 walks.
TEST(SavedWalks, OfPartsThroughGridsOnLatticesAreThoseOfTheWholeRun) {
  for (const Isa isa : {Isa::scalar, supported_isas().back()})
    for (const char* name : {"woven_cloth", "settled_dust"})
      for (const Estimator estimator : {Estimator::analog, Estimator::next_event}) {
        // On lanes counted walks are fast enough to pass the first lattice's end.
        const bool fast = isa != Isa::scalar && estimator == Estimator::analog;
        Case c{load_stack(name), {}, direction_from_degrees(60, 20), estimator, 1000, 3};
        if (fast) c.walks = kBatches * (kLatticePoints + 50);
        c.plan = make_plan(c.stack, {.sampling = Sampling::rqmc});
        c.plan.isa = isa;
        const auto whole = c.simulation();
        ASSERT_EQ(whole->sampling(), Sampling::rqmc);
        on_threads(2, [&] { whole->advance(c.walks); });
        const auto merged = c.simulation();
        std::vector<bool> there;
        constexpr int kParts = 3;
        for (int p = kParts; p-- > 0;) {
          const auto part = c.simulation();
          part->walk_only({p * kBatches / kParts, (p + 1) * kBatches / kParts});
          on_threads(1 + p, [&] {
            part->advance(c.walks / 3);
            part->advance(c.walks);
          });
          EXPECT_TRUE(restore_walks(save_walks(*part, 1, true), *merged, there).done);
        }
        EXPECT_EQ(bits_of(*merged), bits_of(*whole)) << name << ' ' << to_text(isa);
      }
}

TEST(SavedWalks, GoOnAsIfNothingHadEndedThem) {
  Draw draw{RandomStream(1, 3, StreamPurpose::measure)};
  for (int k = 0; k < 40; ++k) {
    const Case c = drawn(draw);
    const auto whole = c.simulation();
    on_threads(2, [&] { whole->advance(c.walks); });
    const auto first = c.simulation();
    on_threads(7, [&] { first->advance(1 + draw.below(c.walks)); });
    const auto second = c.simulation();
    std::vector<bool> there;
    EXPECT_FALSE(restore_walks(save_walks(*first, 1, false), *second, there).done);
    on_threads(1, [&] { second->advance(c.walks); });
    ASSERT_EQ(bits_of(*second), bits_of(*whole)) << to_toml(c.stack);
  }
}

TEST(SavedWalks, StopAtTheSameErrorAfterARestart) {
  const Stack stack = load_stack("sggx_slab");
  const auto make = [&] {
    return std::make_unique<Simulation>(stack, make_plan(stack), direction_from_degrees(60, 0),
                                        Estimator::analog, CellGrid{2, 4, false}, 1);
  };
  const StopRule rule{.walks = 1 << 20, .target_error = 0.01, .seconds = {}};
  const auto whole = make();
  run(*whole, rule, {}, nullptr);
  EXPECT_LT(whole->walks(), rule.walks);
  for (const std::uint64_t at :
       {std::uint64_t{1000}, std::uint64_t{1} << 14, whole->walks() - 5, whole->walks()}) {
    const auto first = make(), second = make();
    first->advance(at);
    std::vector<bool> there;
    restore_walks(save_walks(*first, 1, false), *second, there);
    run(*second, rule, {}, nullptr);
    EXPECT_EQ(second->walks(), whole->walks()) << at;
    EXPECT_EQ(bits_of(*second), bits_of(*whole)) << at;
  }
}

TEST(SavedWalks, RefuseWhatIsDamagedOrAnothersRun) {
  Draw draw{RandomStream(1, 4, StreamPurpose::measure)};
  const Case c = drawn(draw);
  const auto whole = c.simulation();
  whole->advance(c.walks);
  const std::string saved = save_walks(*whole, 1, false);
  const auto refuses = [&](const std::string& bytes) {
    std::vector<bool> there;
    EXPECT_THROW(restore_walks(bytes, *c.simulation(), there), DamagedBytes);
  };
  for (std::size_t size = 0; size < saved.size(); size += 1 + size / 7)
    refuses(saved.substr(0, size));
  refuses(saved + "x");
  // The heads of fields: estimator, walks, seconds, sums, batches, batch 0, its walks, an energy.
  for (const std::size_t at : {0u, 4u, 12u, 21u, 29u, 33u, 37u}) {
    std::string other = saved;
    for (std::size_t k = 0; k < 4; ++k) other[at + k] = static_cast<char>(0xff);
    if (at == 12) std::memcpy(other.data() + at, "\0\0\0\0\0\0\xf8\x7f", 8);  // nan
    refuses(other);
  }
  std::string not_finite = saved;
  std::memcpy(not_finite.data() + 61, "\0\0\0\0\0\0\xf8\x7f", 8);
  refuses(not_finite);
  std::vector<bool> there;
  const auto twice = c.simulation();
  restore_walks(saved, *twice, there);
  EXPECT_THROW(restore_walks(saved, *twice, there), DamagedBytes);
}

}  // namespace
}  // namespace lamella
