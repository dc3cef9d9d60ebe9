#include "compare/truth/solved_texels.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "phase/math/larger_error.h"
#include "phase/stack/stack_file.h"

namespace lamella {
namespace {

template <class Run, class F>
void for_estimates(Run& run, const F& f) {
  const auto all = [&](auto& list) {
    for (auto& e : list) f(e);
  };
  for (auto* side : {&run.reflected, &run.transmitted}) {
    for (auto* list : {&side->total, &side->specular, &side->zero, &side->multiple}) all(*list);
    for (auto& order : side->orders) all(order);
  }
  for (auto* list : {&run.uncollided, &run.absorbed, &run.unresolved, &run.lost, &run.thinned})
    all(*list);
}

template <class Run>
auto estimates_of(Run& run) {
  std::vector<decltype(&run.uncollided[0])> list;
  for_estimates(run, [&](auto& e) { list.push_back(&e); });
  return list;
}

template <class Run>
auto lobes_of(Run& run) {
  std::vector<decltype(&run.reflected.lobes[Order::all])> list;
  for (auto* side : {&run.reflected, &run.transmitted})
    for (auto& lobe : side->lobes) list.push_back(&lobe);
  return list;
}

void make_room(LobeEstimate& lobe, std::size_t cells) {
  lobe.value.resize(std::max(lobe.value.size(), cells));
  lobe.standard_error.resize(lobe.value.size());
}

// A lobe that a texel does not have, as no light leaves there, is 0.
double at(const std::vector<double>& cells, std::size_t k) {
  return k < cells.size() ? cells[k] : 0;
}

void add_to(RunResult& sum, const RunResult& run) {
  const auto to = estimates_of(sum);
  const auto from = estimates_of(run);
  for (std::size_t k = 0; k < to.size(); ++k) {
    to[k]->value += from[k]->value;
    to[k]->standard_error += from[k]->standard_error;
  }
  const auto lobes = lobes_of(sum);
  const auto more = lobes_of(run);
  for (std::size_t l = 0; l < lobes.size(); ++l) {
    make_room(*lobes[l], more[l]->value.size());
    for (std::size_t k = 0; k < more[l]->value.size(); ++k) {
      lobes[l]->value[k] += more[l]->value[k];
      lobes[l]->standard_error[k] += more[l]->standard_error[k];
    }
  }
}

void add_square_of_difference(RunResult& squares, const RunResult& a, const RunResult& b) {
  const auto add = [](double& to, double difference) { to += difference * difference; };
  const auto to = estimates_of(squares);
  const auto first = estimates_of(a), second = estimates_of(b);
  for (std::size_t k = 0; k < to.size(); ++k)
    add(to[k]->standard_error, first[k]->value - second[k]->value);
  const auto lobes = lobes_of(squares);
  const auto left = lobes_of(a), right = lobes_of(b);
  for (std::size_t l = 0; l < lobes.size(); ++l) {
    make_room(*lobes[l], std::max(left[l]->value.size(), right[l]->value.size()));
    for (std::size_t k = 0; k < lobes[l]->value.size(); ++k)
      add(lobes[l]->standard_error[k], at(left[l]->value, k) - at(right[l]->value, k));
  }
}

void keep_worst(RunResult& sum, const RunResult& run) {
  DeterministicAccuracy& to = *sum.accuracy;
  const DeterministicAccuracy& a = *run.accuracy;
  if (!a.reached) to.limit = a.limit;
  to.reached = to.reached && a.reached;
  for (double DeterministicAccuracy::*x :
       {&DeterministicAccuracy::error, &DeterministicAccuracy::node_error,
        &DeterministicAccuracy::second_error, &DeterministicAccuracy::energy_defect})
    to.*x = larger_error(to.*x, a.*x);
  to.nodes = std::max(to.nodes, a.nodes);
  to.modes = std::max(to.modes, a.modes);
  to.harmonics = std::max(to.harmonics, a.harmonics);
  for (std::size_t c = 0; c < 3; ++c)
    to.channel_modes[c] = std::max(to.channel_modes[c], a.channel_modes[c]);
  to.bytes = std::max(to.bytes, a.bytes);
}

}  // namespace

std::vector<std::size_t> first_equals(std::span<const Stack> texels) {
  std::map<std::string, std::size_t> there;
  std::vector<std::size_t> first;
  for (std::size_t k = 0; k < texels.size(); ++k)
    first.push_back(there.try_emplace(to_toml(texels[k]), k).first->second);
  return first;
}

std::size_t count_different(std::span<const std::size_t> first_equals) {
  std::size_t count = 0;
  for (std::size_t k = 0; k < first_equals.size(); ++k) count += first_equals[k] == k;
  return count;
}

void SolvedTexels::add(const std::vector<RunResult>& runs) {
  if (count_ == 0) {
    sums_ = runs;
    squares_ = runs;
    for (RunResult& run : squares_) {
      for_estimates(run, [](Estimate& e) { e = {}; });
      for (LobeEstimate* lobe : lobes_of(run))
        std::fill_n(lobe->standard_error.begin(), lobe->standard_error.size(), 0.0);
    }
  } else {
    for (std::size_t k = 0; k < runs.size(); ++k) {
      add_to(sums_[k], runs[k]);
      keep_worst(sums_[k], runs[k]);
      if (count_ % 2 == 1) add_square_of_difference(squares_[k], last_[k], runs[k]);
    }
  }
  last_ = runs;
  ++count_;
}

std::vector<RunResult> SolvedTexels::mean() const {
  std::vector<RunResult> means = sums_;
  const double share = 1 / static_cast<double>(count_);
  for (RunResult& run : means) {
    for_estimates(run, [&](Estimate& e) { e = {share * e.value, share * e.standard_error}; });
    for (LobeEstimate* lobe : lobes_of(run)) {
      for (double& x : lobe->value) x *= share;
      for (double& x : lobe->standard_error) x *= share;
    }
  }
  return means;
}

std::vector<RunResult> SolvedTexels::map_errors() const {
  std::vector<RunResult> errors = mean();
  const double share = 1 / static_cast<double>(count_);
  for (std::size_t k = 0; k < errors.size(); ++k) {
    const auto to = estimates_of(errors[k]);
    const auto from = estimates_of(squares_[k]);
    for (std::size_t i = 0; i < to.size(); ++i)
      to[i]->standard_error = share * std::sqrt(from[i]->standard_error);
    const auto lobes = lobes_of(errors[k]);
    const auto squares = lobes_of(squares_[k]);
    for (std::size_t l = 0; l < lobes.size(); ++l)
      for (std::size_t i = 0; i < lobes[l]->standard_error.size(); ++i)
        lobes[l]->standard_error[i] = share * std::sqrt(at(squares[l]->standard_error, i));
  }
  return errors;
}

}  // namespace lamella
