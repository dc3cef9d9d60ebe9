#include "compare/command/texel_models.h"

#include <algorithm>

#include "analytic/layered/spongecake.h"
#include "compare/fit/fitted_models.h"
#include "compare/maps/mean_model.h"

namespace lamella {

std::vector<BoundModel> models_of_texels(const std::vector<ModelRequest>& asked,
                                         const std::vector<Stack>& texels, bool solved) {
  std::vector<ModelRequest> requests = requests_for(asked, texels.front());
  // Fits take seconds for every texel: further lobes come from the network, or there are none.
  for (ModelRequest& request : requests)
    if (request.name == "spongecake" && request.values.empty()) {
      const bool predicted = std::all_of(texels.begin(), texels.end(), [](const Stack& texel) {
        return why_no_network(texel).empty();
      });
      request.values.emplace_back("lobes", predicted ? "network" : "none");
    }
  std::vector<std::vector<BoundModel>> bound(requests.size());
  for (const Stack& texel : texels) {
    std::vector<BoundModel> models = fitted_models_for(requests, texel);
    for (std::size_t m = 0; m < models.size(); ++m) bound[m].push_back(std::move(models[m]));
  }
  std::vector<BoundModel> means;
  for (std::size_t m = 0; m < bound.size(); ++m) {
    means.push_back(mean_over_texels(std::move(bound[m]), solved));
    means.back().asked = request_text(requests[m]);
  }
  return means;
}

}  // namespace lamella
