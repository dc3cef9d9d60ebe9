#pragma once

#include "analytic/model.h"

namespace lamella {

/// The two parts of single scattering [1/sr].
struct SingleScattering {
  Rgb layers;     ///< one event in one of the layers
  Rgb substrate;  ///< one reflection from the substrate, attenuated by the layers
};

/// Exact single scattering of any stack, from either side, reflection and transmission:
///   sum over layers of rho sigma(w_i) a p(w_i -> w_o) / (|mu_i| |mu_o|) times the integral over
///   depth of exp(-tau_i - tau_o), tau_i built from sigma(w_i), tau_o from sigma(-w_o);
///   plus f_sub exp(-tau_i - tau_o) through all layers.
/// w_i, w_o: unit, point away from the stack; mu = 0 is the limit from above, at most one of the
/// two. SpongeCake eqs. 8-16 (as corrected in analytic/README.md) for any medium and side. Delta
/// transmission and the mirror image of delta flakes are apart. Relative error below 1e-12, where p
/// is a closed form, for depths from 0 to infinity.
[[nodiscard]] SingleScattering single_scattering(const Stack& stack, Direction wi, Direction wo);

/// The model `single_scattering`: lobes `layers` and `substrate`.
[[nodiscard]] ModelInfo single_scattering_model();

/// What the models that are single scattering share: evaluation, and the sampler that chooses a
/// layer by the light it scatters and then its phase function (SpongeCake, section 4.6).
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
