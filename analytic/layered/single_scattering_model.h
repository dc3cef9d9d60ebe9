#pragma once

#include "analytic/model/model.h"
#include "phase/stack/single_scattering.h"

namespace lamella {

/// The model `single_scattering`: lobes `layers` and `substrate`.
[[nodiscard]] ModelInfo single_scattering_model();

/// The base of models that are single scattering: evaluation, and a sampler that chooses a layer by
/// the light that it scatters and then samples its phase function (SpongeCake, section 4.6).
class SingleScatteringModel final : public Model {
 public:
  explicit SingleScatteringModel(Stack stack) : Model(2), stack_(std::move(stack)) {}

  [[nodiscard]] Rgb eval_lobe(int lobe, Direction wi, Direction wo) const override;
  void eval_lobes(Direction wi, Direction wo, std::span<Rgb> values) const override;
  [[nodiscard]] Rgb eval(Direction wi, Direction wo) const override;
  [[nodiscard]] std::optional<Direction> sample(Direction wo, double u1, double u2,
                                                double u3) const override;
  [[nodiscard]] double pdf(Direction wi, Direction wo) const override;
  [[nodiscard]] double uncollided(Direction wi) const override { return stack_.uncollided(wi); }

 private:
  /// Probability that light traced back along w_o scatters first in each layer, in order from the
  /// top; the last entry is the substrate. They sum to at most 1.
  [[nodiscard]] std::vector<double> first_event(Direction wo) const;

  Stack stack_;
};

}  // namespace lamella
