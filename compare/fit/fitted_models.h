#pragma once

#include <vector>

#include "compare/request/model_request.h"

namespace lamella {

/// SpongeCake's further lobes, where the request leaves them open (lobes = fitted, the default, and
/// none of their own keys given): those that `lamella fit` finds for the stack. Where there is
/// nothing to fit, or it cannot be done, lobes = none, and `sources` says why. Other models'
/// requests stay as they are.
[[nodiscard]] ModelRequest with_fitted_lobes(ModelRequest request, const Stack& stack);

/// The models to judge on a stack, as models_for, with fitted lobes.
[[nodiscard]] std::vector<BoundModel> fitted_models_for(const std::vector<ModelRequest>& requests,
                                                        const Stack& stack);

}  // namespace lamella
