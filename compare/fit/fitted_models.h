#pragma once

#include <vector>

#include "compare/request/model_request.h"

namespace lamella {

/// SpongeCake's further lobes, where the request leaves them open (no key of theirs, lobes = auto,
/// the default, network or fit): those that the network predicts or that `lamella fit` finds, as
/// keys. With auto, `sources` says which, and why not the network; where nothing can be fitted,
/// lobes = none. Throws UsageError where network or fit was asked for and cannot be. Other models'
/// requests stay as they are.
[[nodiscard]] ModelRequest with_fitted_lobes(ModelRequest request, const Stack& stack);

/// The models to judge on a stack, as models_for, with fitted lobes.
[[nodiscard]] std::vector<BoundModel> fitted_models_for(const std::vector<ModelRequest>& requests,
                                                        const Stack& stack);

/// A request for a stack whose values vary over the surface. SpongeCake's lobes, where they are
/// left open, are the network's at every place that it knows; elsewhere those of the middle, whose
/// parameters are factors of the layers' own.
struct PlacedRequest {
  ModelRequest own, of_middle;
  bool predicts = false;
};
[[nodiscard]] PlacedRequest placed_request(const ModelRequest& request, const Stack& middle);
/// The model of a place; any thread. Throws UsageError where the request does not suit it.
[[nodiscard]] BoundModel model_at(const PlacedRequest& request, const Stack& place);

}  // namespace lamella
