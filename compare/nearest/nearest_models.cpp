#include "compare/nearest/nearest_models.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "analytic/catalogue/model_plugin.h"
#include "compare/request/errors.h"

namespace lamella {
namespace {

const ModelInfo& info_of(const ModelRequest& request) {
  const ModelInfo* info = find_or_load_model(request.name);
  if (!info) check_request({request.name, {}});  // throws
  return *info;
}

}  // namespace

std::vector<ParametricModel> parametric_models(const std::vector<ModelRequest>& requests,
                                               int channels) {
  std::vector<ParametricModel> models;
  for (const ModelRequest& request : requests)
    models.push_back(parametric_model(info_of(request), request, channels));
  return models;
}

NearestModels nearest_models(const TargetTruths& target, const std::vector<ParametricModel>& models,
                             FitNorm norm, FitSides sides, const RunMonitor& monitor) {
  NearestModels nearest{.norm = norm,
                        .transmitted = sides == FitSides::all && target.plan.transmits,
                        .fits = {},
                        .refused = {},
                        .interrupted = target.interrupted};
  FitTarget cells;
  try {
    cells = fit_target(target.truths, nearest.transmitted);
  } catch (const std::invalid_argument& error) {
    throw UsageError(fmt::format("fit: {}: {}; allowed: a target that scatters light",
                                 target.request.stack.name, error.what()));
  }
  for (const ParametricModel& model : models) {
    if (monitor.is_stopped() && !nearest.fits.empty()) {
      nearest.interrupted = true;
      break;
    }
    try {
      nearest.fits.push_back(fit_model(model, cells, norm, target.request.isa, monitor.stop));
    } catch (const std::domain_error& error) {
      nearest.refused.push_back(fmt::format("{}: {}", model.request.name, error.what()));
    }
  }
  if (nearest.fits.empty())
    throw UsageError(fmt::format("fit: {}; allowed: a model with values", nearest.refused.front()));
  std::stable_sort(nearest.fits.begin(), nearest.fits.end(),
                   [](const ModelFit& a, const ModelFit& b) { return a.misfit < b.misfit; });
  nearest.interrupted = nearest.interrupted || monitor.is_stopped();
  return nearest;
}

std::vector<BoundModel> bound_models(const NearestModels& nearest) {
  std::vector<BoundModel> models;
  for (const ModelFit& fit : nearest.fits) {
    BoundModel bound;
    bound.info = fit.info;
    bound.parameters = read_parameters(fit.request.name, parameters_of(*fit.info, fit.request),
                                       fit.request.values);
    bound.model = fit.info->make(bound.parameters, nullptr);
    for (const auto& [key, value] : bound.parameters.all()) {
      const bool given = std::any_of(fit.request.values.begin(), fit.request.values.end(),
                                     [&, &k = key](const auto& v) { return v.first == k; });
      bound.sources[key] = fit.request.sources.contains(key) ? fit.request.sources.at(key)
                           : given                           ? "given"
                                                             : "default";
    }
    if (is_plugin_path(fit.request.name)) bound.object = fit.request.name;
    models.push_back(std::move(bound));
  }
  return models;
}

}  // namespace lamella
