#pragma once

#include "compare/request/model_request.h"

namespace lamella {

/// The request, completed by what the stack says of the model's parameters: where the model applies
/// to it, what the model makes of it (ModelInfo::applies_to); else whatever both have a name for,
/// such as albedo, roughness, alpha, g, f0, tau0, beta. Of several layers that is taken which all
/// of them have and agree on. A substrate is what lies below micrograins: `bulk`, `bulk_albedo`.
/// Keys that were given win. `sources` tells of every key that was taken, and why one was not.
[[nodiscard]] ModelRequest with_stack_parameters(ModelRequest request, const ModelInfo& info,
                                                 const Stack& stack);

/// The request without the key `stack` of a model that is built from one. Throws UsageError where
/// the key names another stack than `of`, the one that the command is about, or says nothing.
[[nodiscard]] ModelRequest without_stack_key(ModelRequest request, const Stack& of);

/// A model for a stack: what the request leaves open comes from the stack, where both have a name
/// for it. The key `stack` may name that stack once more.
[[nodiscard]] BoundModel model_for(const ModelRequest& request, const Stack& stack);

/// The models to judge on a stack: those asked for, or else all that apply to it.
[[nodiscard]] std::vector<BoundModel> models_for(const std::vector<ModelRequest>& requests,
                                                 const Stack& stack);

}  // namespace lamella
