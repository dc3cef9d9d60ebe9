#pragma once

#include "compare/request/model_request.h"

namespace lamella {

/// The request, completed by the stack's values of the model's parameters. Where the model applies
/// to the stack, they are those of ModelInfo::applies_to; else those of the parameters that both
/// have a name for: albedo, roughness, alpha, g, f0, tau0, beta, ... Of several layers a value is
/// taken if all of them have it and agree. The substrate below micrograins gives `bulk` and
/// `bulk_albedo`. Keys that were given win. `sources` names every key that was taken, and the
/// reason why one was not.
[[nodiscard]] ModelRequest with_stack_parameters(ModelRequest request, const ModelInfo& info,
                                                 const Stack& stack);

/// The request without the key `stack` of a model that is built from one. Throws UsageError where
/// the key names another stack than `of`, the one that the command is about, or says nothing.
[[nodiscard]] ModelRequest without_stack_key(ModelRequest request, const Stack& of);

/// A model for a stack: parameters that the request leaves open come from the stack, where both
/// have a name for them. The key `stack` may name that stack once more.
[[nodiscard]] BoundModel model_for(const ModelRequest& request, const Stack& stack);

/// The models to judge on a stack: those asked for, or else all that apply to it.
[[nodiscard]] std::vector<BoundModel> models_for(const std::vector<ModelRequest>& requests,
                                                 const Stack& stack);

}  // namespace lamella
