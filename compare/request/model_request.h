#pragma once

#include <memory>

#include "analytic/model/model.h"
#include "compare/options/options.h"

namespace lamella {

/// A model with its parameters fixed.
struct BoundModel {
  const ModelInfo* info = nullptr;
  Parameters parameters;
  std::unique_ptr<Model> model;
};

/// Builds a model from its name and key=value texts; `stack` serves models that need one. Throws
/// UsageError that names the key, what was found and what is allowed.
[[nodiscard]] BoundModel bind_model(const ModelRequest& request, const Stack* stack);

/// The models to judge on a stack: those asked for, or else all that apply to it.
[[nodiscard]] std::vector<BoundModel> models_for(const Options& options, const Stack& stack);

/// The models' names; where one is there several times, with a number each: for files and columns.
[[nodiscard]] std::vector<std::string> distinct_names(const std::vector<BoundModel>& models);

/// The model as --model takes it: NAME,key=value,...
[[nodiscard]] std::string to_request(const BoundModel& model);

/// Reads key=value texts by a list of parameters, defaults filled in. `what` is named in errors.
[[nodiscard]] Parameters read_parameters(
    const std::string& what, const std::vector<ParameterInfo>& infos,
    const std::vector<std::pair<std::string, std::string>>& values);

/// Nanoseconds per evaluation of one pair, of single calls.
[[nodiscard]] double nanoseconds_per_eval(const Model& model);

}  // namespace lamella
