#pragma once

#include <vector>

#include "compare/request/model_request.h"
#include "phase/stack/stack.h"

namespace lamella {

/// The models that were asked for, or those that apply to the first texel, as their means over all
/// (mean_over_texels). SpongeCake's further lobes, where no key says otherwise, are the network's,
/// if it knows every texel, or there are none. solved: without noise, as their truth has none.
[[nodiscard]] std::vector<BoundModel> models_of_texels(const std::vector<ModelRequest>& requests,
                                                       const std::vector<Stack>& texels,
                                                       bool solved);

}  // namespace lamella
