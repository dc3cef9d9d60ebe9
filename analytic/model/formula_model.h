#pragma once

#include "analytic/model/batch_evaluate.h"
#include "analytic/model/model.h"

namespace lamella {

/// A closed form whose value is one formula of analytic/model/batch_evaluate.h: single pairs in
/// double, batches on lanes.
template <class Formula>
class FormulaModel : public Model {
 public:
  // Flattened, so that angles which the formula does not ask for are not computed.
  [[nodiscard, gnu::flatten]] Rgb eval(Direction wi, Direction wo) const override {
    const auto a = reflection_angles(wi, wo);
    if (!a) return Rgb();
    const auto shared = formula_.shared(*a);
    return per_channel([&](int c) { return formula_.channel(shared, c); });
  }
  void eval(std::span<const DirectionPair> pairs, std::span<Rgb> values, Isa isa) const override {
    const BatchFunction<Formula> lanes = lanes_for_(isa);
    if (!lanes) return Model::eval(pairs, values, isa);
    static_assert(sizeof(DirectionPair) == 6 * sizeof(double) && sizeof(Rgb) == 3 * sizeof(double));
    lanes(&formula_, grey_ ? 1 : 3, reinterpret_cast<const double*>(pairs.data()),
          reinterpret_cast<double*>(values.data()), pairs.size());
  }

 protected:
  FormulaModel(int lobes, const Formula& formula, bool grey,
               BatchFunction<Formula> (*lanes_for)(Isa))
      : Model(lobes), formula_(formula), grey_(grey), lanes_for_(lanes_for) {}

  template <class F>
  [[nodiscard]] Rgb per_channel(const F& f) const {
    return grey_ ? Rgb(f(0)) : Rgb(f(0), f(1), f(2));
  }

  Formula formula_;

 private:
  bool grey_;
  BatchFunction<Formula> (*lanes_for_)(Isa);
};

}  // namespace lamella
