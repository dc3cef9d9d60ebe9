#pragma once

#include "analytic/model/reflection_angles.h"
#include "phase/lanes/double_lanes.h"

// How a batch of pairs is evaluated on lanes. Only for sources of lamella_lanes(), see
// phase/lanes/lanes.h: half_space_lanes.cpp is one.

namespace lamella::LAMELLA_ISA {
namespace {

constexpr std::size_t kStep = Doubles::kCount;
constexpr std::size_t kPairNumbers = 6, kValueNumbers = 3;

// Blocks of two numbers are what the shuffles of every set work on: block b of a register belongs
// to pairs 2 b and 2 b + 1. Reads block b at from + 2 b stride.
template <class D>
LAMELLA_INLINE hn::Vec<D> load_blocks(D d, const double* from, std::size_t stride) {
  if constexpr (hn::MaxLanes(D()) == 2) {
    return hn::LoadU(d, from);
  } else {
    const hn::Half<D> half;
    const std::size_t upper = stride * hn::MaxLanes(half);
    return hn::Combine(d, load_blocks(half, from + upper, stride), load_blocks(half, from, stride));
  }
}
template <class D>
LAMELLA_INLINE void store_blocks(D d, hn::Vec<D> v, double* to, std::size_t stride) {
  if constexpr (hn::MaxLanes(D()) == 2) {
    hn::StoreU(v, d, to);
  } else {
    const hn::Half<D> half;
    store_blocks(half, hn::LowerHalf(half, v), to, stride);
    store_blocks(half, hn::UpperHalf(half, v), to + stride * hn::MaxLanes(half), stride);
  }
}

struct TwoLanes {
  Doubles first, second;
};

// Numbers k and k + 1 of each pair.
LAMELLA_INLINE TwoLanes load_numbers(const double* pairs, std::size_t k) {
  const Doubles::Tag d;
  const auto even = load_blocks(d, pairs + k, kPairNumbers);
  const auto odd = load_blocks(d, pairs + kPairNumbers + k, kPairNumbers);
  return {hn::InterleaveLower(d, even, odd), hn::InterleaveUpper(d, even, odd)};
}

LAMELLA_INLINE void store_values(Doubles r, Doubles g, Doubles b, double* values) {
  const Doubles::Tag d;
  store_blocks(d, hn::InterleaveLower(d, r.v, g.v), values, kValueNumbers);
  store_blocks(d, hn::OddEven(r.v, b.v), values + 2, kValueNumbers);
  store_blocks(d, hn::InterleaveUpper(d, g.v, b.v), values + 4, kValueNumbers);
}

template <int kChannels, class Formula>
LAMELLA_INLINE void evaluate_step(const Formula& formula, const double* pairs, double* values) {
  const auto [xi, yi] = load_numbers(pairs, 0);
  const auto [zi, xo] = load_numbers(pairs, 2);
  const auto [yo, zo] = load_numbers(pairs, 4);
  const Doubles zero(0);
  const DoubleMask above = (zi >= zero) & (zo >= zero);
  const Angles<Doubles> angles = angles_above(Vec3<Doubles>{xi, yi, zi}, Vec3<Doubles>{xo, yo, zo});
  const auto shared = formula.shared(angles);
  const Doubles r = select(above, formula.channel(shared, 0), zero);
  if constexpr (kChannels == 1)
    store_values(r, r, r, values);
  else
    store_values(r, select(above, formula.channel(shared, 1), zero),
                 select(above, formula.channel(shared, 2), zero), values);
}

/// step(pairs, values) of kStep pairs, for all of them.
template <class Step>
LAMELLA_INLINE void step_by_step(const Step& step, const double* pairs, double* values,
                                 std::size_t count) {
  std::size_t k = 0;
  for (; k + kStep <= count; k += kStep) step(pairs + kPairNumbers * k, values + kValueNumbers * k);
  if (k == count) return;
  // The rest, filled up with the last pair.
  double padded[kPairNumbers * kStep], results[kValueNumbers * kStep];
  for (std::size_t lane = 0; lane < kStep; ++lane) {
    const std::size_t from = k + lane < count ? k + lane : count - 1;
    for (std::size_t n = 0; n < kPairNumbers; ++n)
      padded[kPairNumbers * lane + n] = pairs[kPairNumbers * from + n];
  }
  step(padded, results);
  for (std::size_t n = 0; n < kValueNumbers * (count - k); ++n)
    values[kValueNumbers * k + n] = results[n];
}

template <int kChannels, class Formula>
LAMELLA_INLINE void evaluate_all(const Formula& given, const double* pairs, double* values,
                                 std::size_t count) {
  const Formula formula = given;  // which the values cannot overwrite
  step_by_step([&](const double* from, double* to)
                   LAMELLA_INLINE_LAMBDA { evaluate_step<kChannels>(formula, from, to); },
               pairs, values, count);
}

template <class Formula>
LAMELLA_INLINE void evaluate(const Formula& formula, int channels, const double* pairs,
                             double* values, std::size_t count) {
  if (channels == 1)
    evaluate_all<1>(formula, pairs, values, count);
  else
    evaluate_all<3>(formula, pairs, values, count);
}

}  // namespace

/// Defines a function of a LAMELLA_BATCH_FORMULAS list. Flattened, so that angles which the formula
/// does not ask for are not computed.
#define LAMELLA_DEFINE_BATCH_FUNCTION(name, Formula)                                    \
  [[gnu::flatten]] void name(const Formula* formula, int channels, const double* pairs, \
                             double* values, std::size_t count) {                       \
    evaluate(*formula, channels, pairs, values, count);                                 \
  }

}  // namespace lamella::LAMELLA_ISA
