#include "compare/judge/pair_values.h"

#include "analytic/model/batched_model.h"

namespace lamella {

bool is_batched(const Model& model) { return dynamic_cast<const BatchedModel*>(&model) != nullptr; }

std::vector<Rgb> pair_values(const Model& model, std::span<const DirectionPair> pairs) {
  std::vector<Rgb> values(pairs.size());
  if (is_batched(model))
    model.eval(pairs, values, Isa::scalar);
  else
    for (std::size_t k = 0; k < pairs.size(); ++k) values[k] = model.eval(pairs[k].wi, pairs[k].wo);
  return values;
}

}  // namespace lamella
