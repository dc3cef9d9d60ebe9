#pragma once

#include <memory>
#include <span>

#include "analytic/model/model.h"

namespace lamella {

/// The baselines of closed forms in `lamella bench`: one grey model as a careful user would write
/// it from its paper, in scalar double, one pair after the other, with the parameters' own factors
/// computed once. They share the coefficients' values with analytic/, and no code.
class TextbookModel {
 public:
  virtual ~TextbookModel() = default;
  /// values[k] = f [1/sr] at pairs[k]; directions above the surface. The spans have the same
  /// length.
  virtual void eval(std::span<const DirectionPair> pairs, std::span<double> values) const = 0;
};

/// The textbook version of a model by its name, or nullptr: `lambert_sphere`, `vmf_diffuse`, `eon`,
/// `eon_approx`, `fon`. Of a colour the green counts.
[[nodiscard]] std::unique_ptr<TextbookModel> textbook_model(const std::string& name,
                                                            const Parameters& parameters);

}  // namespace lamella
