#pragma once

#include "analytic/model/model.h"
#include "compare/judge/furnace.h"

namespace lamella {

/// The furnace of a closed form in one direction: the light that leaves, the delta included.
struct ModelFurnace {
  Rgb energy;
  Rgb error;  ///< bound of the quadrature; of a stochastic model one standard error
  IntegralEnd end = IntegralEnd::tolerance;  ///< of that quadrature
  FurnaceVerdict verdict = FurnaceVerdict::pass;
  bool loses = false, gains = false;  ///< where it fails
};

/// Passes where every channel's energy is 1 within `tolerance`; with `as_is`, where none is above 1
/// by more. The energy is known to its error, of a stochastic model to furnace_quantile(1e-3)
/// standard errors: it fails where it is off by more than tolerance and error together, and is
/// inconclusive where it is off by more than the tolerance less the error. Throws std::domain_error
/// where an energy is not finite.
[[nodiscard]] ModelFurnace judge_model_furnace(const Model& model, Direction wi, bool as_is,
                                               double tolerance);

}  // namespace lamella
