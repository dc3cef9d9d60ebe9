#pragma once

#include "analytic/model/model.h"

namespace lamella {

/// A closed form of which a call costs much more than a pair, as a function of another language
/// does: it is asked for many pairs at a time wherever many are needed. It has one lobe.
class BatchedModel : public Model {
 public:
  using Model::eval;
  void eval(std::span<const DirectionPair> pairs, std::span<Rgb> values,
            Isa isa) const override = 0;

  /// One pair, in a batch of its own.
  [[nodiscard]] Rgb eval_lobe(int /*lobe*/, Direction wi, Direction wo) const override {
    const DirectionPair pair{wi, wo};
    Rgb value;
    eval({&pair, 1}, {&value, 1}, Isa::scalar);
    return value;
  }

 protected:
  BatchedModel() : Model(1) {}
};

}  // namespace lamella
