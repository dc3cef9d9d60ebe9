#include "compare/library/library_verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <numeric>
#include <random>

#include "compare/judge/lobe_sums.h"
#include "compare/judge/missing_light.h"
#include "compare/request/errors.h"
#include "volume/result/tally.h"

namespace lamella {
namespace {

constexpr double kEntryFalseAlarm = 1e-3;
constexpr double kRounding = 1e-12;  // of the brightest value

// A value with what is known of its error.
struct Known {
  double value = 0, error = 0;
  bool bounded = true;
};

// Whether the error of a value by walks is near enough to normal.
bool has_events(const Known& x) {
  return x.bounded || x.error == 0 ||
         (x.value > 0 && x.value * x.value >= kPooledEvents * x.error * x.error);
}

// A value by walks without any event has no error to judge by.
bool is_empty(const Known& x) { return !x.bounded && x.error == 0 && x.value == 0; }

// By how much two findings may differ.
double allowed_between(const Known& a, const Known& b, double quantile) {
  double sure = 0, squares = 0;
  for (const Known& x : {a, b})
    if (x.bounded)
      sure += x.error;
    else
      squares += x.error * x.error;
  return sure + quantile * std::sqrt(squares);
}

std::uint64_t values_of(const Reference& reference) {
  std::uint64_t count = reference.f.size() * reference.set.channels;
  for (const LobeBlock& lobe : reference.set.lobes) count += lobe.value.size();
  return std::max<std::uint64_t>(count, 1);
}

// Per [direction][channel], how much the mean of a cell may lack where walks were cut.
std::vector<double> missing_in_cells(const Reference& kept, const Reference& again) {
  const std::size_t count = kept.set.directions.size() * kept.set.channels;
  std::vector<double> missing(count);
  for (const Reference* reference : {&kept, &again})
    for (std::size_t k = 0; k < reference->unresolved.size(); ++k)
      missing[k] += reference->unresolved[k] / reference->set.grid.projected_solid_angle();
  return missing;
}

}  // namespace

CheckLine compare_references(const Reference& kept, const Reference& again,
                             const std::string& entry) {
  CheckLine line{entry, "found again within the stated errors"};
  const bool same = kept.set.directions.size() == again.set.directions.size() &&
                    kept.set.grid == again.set.grid && kept.set.channels == again.set.channels &&
                    kept.set.lobes.size() == again.set.lobes.size() &&
                    kept.pairs.size() == again.pairs.size();
  const auto refuse = [&](const std::string& what) {
    line.offer(HUGE_VAL, 0, [&] { return CheckCase{.text = what, .parameters = entry}; });
  };
  if (!same) refuse("another number of lobes, cells, channels, directions or points");
  if (!same) return line;
  const boost::math::students_t students(kBatches - 1);
  const double level = kEntryFalseAlarm / static_cast<double>(values_of(kept));
  const double quantile = boost::math::quantile(boost::math::complement(students, level / 2));
  const std::vector<double> missing = missing_in_cells(kept, again);
  const auto offer = [&](const Known& a, const Known& b, double more, double brightest,
                         const auto& where, Direction wi, std::optional<Direction> wo) {
    if (is_empty(a) || is_empty(b) || !has_events(a) || !has_events(b)) {
      ++line.undecided;
      ++line.cases;
      return;
    }
    const double found = std::abs(a.value - b.value);
    line.offer(found, allowed_between(a, b, quantile) + more + kRounding * brightest, [&] {
      return CheckCase{.text = fmt::format("{}: {:.9g} +- {:.1e} kept, {:.9g} +- {:.1e} found",
                                           where(), a.value, a.error, b.value, b.error),
                       .parameters = entry,
                       .wi = wi,
                       .wo = wo};
    });
  };
  const bool bounded = kept.lobe_method.is_bounded(), too = again.lobe_method.is_bounded();
  const std::size_t cells = kept.set.grid.cells();
  for (const LobeBlock& lobe : kept.set.lobes) {
    const LobeBlock* other = again.set.lobe(lobe.side, lobe.name);
    if (!other || other->value.size() != lobe.value.size() ||
        lobe.standard_error.size() != lobe.value.size() ||
        other->standard_error.size() != lobe.value.size()) {
      refuse(fmt::format("no lobe {} {}", lobe.side, lobe.name));
      continue;
    }
    const double brightest = *std::max_element(lobe.value.begin(), lobe.value.end());
    for (std::size_t k = 0; k < lobe.value.size(); ++k)
      offer(
          {lobe.value[k], lobe.standard_error[k], bounded},
          {other->value[k], other->standard_error[k], too}, missing[k / cells], brightest,
          [&] { return fmt::format("{} {}, cell {}", lobe.side, lobe.name, k % cells); },
          kept.set.directions[k / cells / kept.set.channels], std::nullopt);
  }
  double brightest = 0;
  for (const Rgb& f : kept.f) brightest = std::max(brightest, f.max());
  for (std::size_t k = 0; k < kept.pairs.size(); ++k)
    for (int c = 0; c < kept.set.channels; ++c)
      offer(
          {kept.f[k][c], kept.f_error[k][c], kept.point_method.is_bounded()},
          {again.f[k][c], again.f_error[k][c], again.point_method.is_bounded()}, 0, brightest,
          [&] { return fmt::format("point {}", k + 1); }, kept.pairs[k].wi, kept.pairs[k].wo);
  return line;
}

LibraryVerificationResult verify_library(const LibraryVerification& verification,
                                         const RunMonitor& monitor) {
  const LibraryIndex index = read_index(verification.folder);
  std::vector<std::string> names;
  for (const LibraryEntry& entry : index.entries) names.push_back(entry.name);
  check_names(verification.only, names, "--only");
  LibraryVerificationResult result;
  std::vector<const LibraryEntry*> chosen;
  for (const LibraryEntry& entry : index.entries) {
    if (!verification.only.empty() && std::find(verification.only.begin(), verification.only.end(),
                                                entry.name) == verification.only.end())
      continue;
    ++result.entries;
    if (const auto broken = why_not_whole(entry, verification.folder))
      result.broken.push_back(fmt::format("{}: {}", entry.name, *broken));
    else
      chosen.push_back(&entry);
  }
  // The same draw for a seed, whichever library of C++ shuffles.
  std::mt19937_64 draw(verification.effort.seed);
  for (std::size_t k = chosen.size(); k > 1; --k) std::swap(chosen[k - 1], chosen[draw() % k]);
  if (verification.sample > 0 && chosen.size() > verification.sample)
    chosen.resize(verification.sample);
  std::sort(chosen.begin(), chosen.end());
  for (const LibraryEntry* entry : chosen) {
    const Reference kept = read_reference(*entry, verification.folder);
    ReferenceEffort effort = verification.effort;
    // Walks that are not those of the entry: their errors are independent.
    if (effort.seed == entry->seed) ++effort.seed;
    effort.cells = {.mu_cells = kept.set.grid.mu_cells, .phi_cells = kept.set.grid.phi_cells};
    if (!effort.walks_only && !kept.lobe_method.is_bounded() && !kept.point_method.is_bounded())
      effort.walks_only = true;
    const auto again = find_reference(stack_of_entry(*entry), effort, monitor);
    if (monitor.finished) monitor.finished();
    if (!again) {
      result.interrupted = true;
      break;
    }
    result.lines.push_back(compare_references(kept, *again, entry->name));
    if (verification.done) verification.done(result.lines.back(), *entry);
  }
  return result;
}

}  // namespace lamella
