#include "volume/result/run_bytes.h"

#include <type_traits>

#include "volume/result/number_bytes.h"

namespace lamella {
namespace {

// One list of the members serves writing and reading: Io is called with each of them.
template <class Io>
struct Members {
  Io io;

  template <class T, std::size_t N>
  void all(std::array<T, N>& list) {
    for (T& one : list) each(one);
  }
  template <class T>
  void each(T& value) {
    if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>)
      io.number(value);
    else
      of(value);
  }
  template <class T, std::size_t N>
  void of(std::array<T, N>& list) {
    all(list);
  }
  void of(std::vector<double>& values) { io.list(values); }
  void of(Estimate& e) {
    each(e.value);
    each(e.standard_error);
  }
  void of(LobeEstimate& lobe) {
    of(lobe.value);
    of(lobe.standard_error);
  }
  void of(SideResult& side) {
    all(side.total);
    all(side.specular);
    all(side.zero);
    all(side.orders);
    all(side.multiple);
    all(side.lobes);
  }
  void of(CellGrid& grid) {
    each(grid.mu_cells);
    each(grid.phi_cells);
    each(grid.folded);
  }
  void of(DeterministicAccuracy& a) {
    each(a.reached);
    each(a.limit);
    for (double* x : {&a.error, &a.node_error, &a.second_error, &a.energy_defect, &a.seconds})
      each(*x);
    for (int* n : {&a.nodes, &a.modes, &a.harmonics}) each(*n);
    all(a.channel_modes);
    each(a.bytes);
  }
  void of(RunResult& run) {
    for (double* x : {&run.incident.x, &run.incident.y, &run.incident.z, &run.seconds}) each(*x);
    each(run.estimator);
    of(run.grid);
    each(run.channels);
    for (std::uint64_t* n : {&run.walks, &run.collisions, &run.max_order, &run.holes}) each(*n);
    each(run.thinning.first);
    each(run.sampling);
    each(run.order_one);
    each(run.order_one_p_value);
    of(run.reflected);
    of(run.transmitted);
    for (auto* e : {&run.uncollided, &run.absorbed, &run.unresolved, &run.lost, &run.thinned})
      all(*e);
    bool bounded = run.accuracy.has_value();
    each(bounded);
    if (bounded && !run.accuracy) run.accuracy.emplace();
    if (bounded) of(*run.accuracy);
  }
};

struct Write {
  NumberWriter out{};
  template <class T>
  void number(const T& value) {
    if constexpr (std::is_enum_v<T>)
      out.put(static_cast<std::int32_t>(value));
    else
      out.put(value);
  }
  void list(const std::vector<double>& values) {
    out.put(static_cast<std::uint64_t>(values.size()));
    out.put_all(std::span<const double>(values));
  }
};

struct Read {
  NumberReader in;
  template <class T>
  void number(T& value) {
    if constexpr (std::is_same_v<T, bool>)
      value = in.get<std::uint8_t>() != 0;
    else if constexpr (std::is_enum_v<T>)
      value = static_cast<T>(in.get<std::int32_t>());
    else
      value = in.get<T>();
  }
  void list(std::vector<double>& values) {
    const auto size = in.get<std::uint64_t>();
    if (size > in.left() / sizeof(double)) throw DamagedBytes("it ends within a lobe");
    values.resize(static_cast<std::size_t>(size));
    in.fill(std::span<double>(values));
  }
};

// What the rest of the program takes for granted of a solver's result.
void check(const RunResult& run) {
  const bool fits = run.estimator == Estimator::deterministic && run.accuracy &&
                    run.accuracy->limit >= DeterministicLimit::none &&
                    run.accuracy->limit <= DeterministicLimit::numbers &&
                    (run.channels == 1 || run.channels == 3) && run.grid.mu_cells > 0 &&
                    run.grid.phi_cells > 0 && run.grid.mu_cells <= 4096 &&
                    run.grid.phi_cells <= 4096;
  if (!fits) throw DamagedBytes("it has no result of the solver");
  const auto cells = static_cast<std::size_t>(run.channels) * run.grid.cells();
  for (const SideResult* side : {&run.reflected, &run.transmitted})
    for (const LobeEstimate& lobe : side->lobes)
      if (lobe.value.size() != lobe.standard_error.size() ||
          (!lobe.value.empty() && lobe.value.size() != cells))
        throw DamagedBytes("a lobe has another number of cells");
}

}  // namespace

std::string to_bytes(const RunResult& run) {
  Members<Write> members;
  RunResult copy = run;
  members.of(copy);
  return members.io.out.take();
}

RunResult run_from_bytes(std::string_view bytes) {
  Members<Read> members{{NumberReader(bytes)}};
  RunResult run;
  members.of(run);
  members.io.in.end();
  check(run);
  return run;
}

}  // namespace lamella
