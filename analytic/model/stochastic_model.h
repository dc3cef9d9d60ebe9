#pragma once

#include "analytic/model/model.h"

namespace lamella {

/// A value of the BSDF and its standard error, per channel.
struct ValueWithError {
  Rgb f, standard_error;
};

/// A closed form whose values are estimates: eval is a mean over a fixed set of random numbers.
class StochasticModel : public Model {
 public:
  /// eval with its standard error.
  [[nodiscard]] virtual ValueWithError eval_with_error(Direction wi, Direction wo) const = 0;
  /// eval_lobe with its standard error.
  [[nodiscard]] virtual ValueWithError eval_lobe_with_error(int lobe, Direction wi,
                                                            Direction wo) const = 0;

  /// Independent estimates of the same model, about `parts` of them, whose scatter is eval's noise
  /// with its covariance: eval is their mean, up to uneven shares of the random numbers.
  [[nodiscard]] virtual std::vector<std::unique_ptr<Model>> split(int parts) const = 0;

 protected:
  using Model::Model;
};

}  // namespace lamella
