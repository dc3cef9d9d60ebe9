#pragma once

#include "analytic/model.h"

namespace lamella {

/// A value of the BSDF and its standard error, per channel.
struct ValueWithError {
  Rgb f, standard_error;
};

/// A closed form whose values are estimates: eval is the mean of a fixed set of random numbers.
class StochasticModel : public Model {
 public:
  /// eval with its standard error.
  [[nodiscard]] virtual ValueWithError eval_with_error(Direction wi, Direction wo) const = 0;

 protected:
  using Model::Model;
};

}  // namespace lamella
