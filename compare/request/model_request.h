#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "analytic/model/model.h"

namespace lamella {

/// key=value texts, in the order in which they were given.
using KeyValues = std::vector<std::pair<std::string, std::string>>;

/// A model as it is asked for: NAME,key=value,...
struct ModelRequest {
  std::string name;
  KeyValues values;
  /// The origin of values that were not given, by key ("stack", "fitted", ...), and why a default
  /// stands.
  std::map<std::string, std::string> sources{};
};

/// Splits "NAME,key=value,..."; a comma inside a value (albedo=0.9,0.5,0.2) stays with it. Throws
/// UsageError.
[[nodiscard]] ModelRequest parse_model_request(const std::string& text);

/// The request of several words: the name, then one key=value each. Throws UsageError.
[[nodiscard]] ModelRequest parse_model_words(const std::vector<std::string>& words);

/// A model with its parameters fixed.
struct BoundModel {
  const ModelInfo* info = nullptr;
  Parameters parameters;
  std::unique_ptr<Model> model;
  /// Where each parameter's value comes from: "given", "stack", "fitted", "default", or in more
  /// words.
  std::map<std::string, std::string> sources{};
  std::string object{};  ///< path of the shared object that it comes from; empty: built in
  /// Of a mean over texels: NAME[,key=value...] that every texel's own model was asked for by, as
  /// `parameters` are means. Else empty.
  std::string asked{};
};

/// The shared objects that the models come from.
[[nodiscard]] std::vector<std::filesystem::path> objects_of(const std::vector<BoundModel>& models);

/// The shared objects of requests, before anything is loaded.
[[nodiscard]] std::vector<std::filesystem::path> objects_among(
    const std::vector<ModelRequest>& requests);

/// Throws UsageError for a model or a key that is unknown or a value that is not allowed: cheap,
/// before any work. Keys that a stack is named by are the caller's.
void check_request(const ModelRequest& request);

/// Builds a model from its name and key=value texts; `stack` serves models that need one. Throws
/// UsageError, which names the key, the value found and the values allowed.
[[nodiscard]] BoundModel bind_model(const ModelRequest& request, const Stack* stack);

/// The parameters that the request's model has, with those that its own choice of the selector
/// brings along. Throws UsageError where that choice is not allowed.
[[nodiscard]] std::vector<ParameterInfo> parameters_of(const ModelInfo& info,
                                                       const ModelRequest& request);

/// A value as a request has it: to_text without brackets, quotes and blanks.
[[nodiscard]] std::string request_value(const ParameterValue& value);

/// The requests, or, if there are none, one for each model that applies to the stack.
[[nodiscard]] std::vector<ModelRequest> requests_for(const std::vector<ModelRequest>& requests,
                                                     const Stack& stack);

/// "key = value (source)" of every parameter, in the model's order. Numbered keys (NAME_1, NAME_2,
/// ...) end with the highest number that is no default's.
[[nodiscard]] std::vector<std::string> told_parameters(const BoundModel& model);
/// The parameters as lines of at most `width` columns, each after `indent` blanks and ended by
/// '\n'.
[[nodiscard]] std::string told_parameters(const BoundModel& model, int indent, int width = 100);

/// The models' names; where one is there several times, with a number each: for files and columns.
[[nodiscard]] std::vector<std::string> distinct_names(const std::vector<BoundModel>& models);

/// What people read in the place of distinct_names: where a name is there several times, with the
/// keys that were given and differ, "coated, layering=wolff"; where none does, with a number each.
[[nodiscard]] std::vector<std::string> distinct_labels(const std::vector<BoundModel>& models);

/// The model as --model takes it: NAME,key=value,...
[[nodiscard]] std::string to_request(const BoundModel& model);
/// The same of a request: what it was asked for by.
[[nodiscard]] std::string request_text(const ModelRequest& request);

/// Reads key=value texts by a list of parameters, defaults filled in. `what` is named in errors.
[[nodiscard]] Parameters read_parameters(const std::string& what,
                                         const std::vector<ParameterInfo>& infos,
                                         const KeyValues& values);

/// Nanoseconds per evaluation of one pair, of single calls.
[[nodiscard]] double nanoseconds_per_eval(const Model& model);

}  // namespace lamella
