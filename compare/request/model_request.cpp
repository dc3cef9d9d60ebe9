#include "compare/request/model_request.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>

#include "analytic/catalogue/model_plugin.h"
#include "analytic/model/batched_model.h"
#include "compare/request/errors.h"

namespace lamella {

ModelRequest parse_model_request(const std::string& text) {
  ModelRequest request;
  std::size_t from = 0;
  for (bool first = true; from <= text.size(); first = false) {
    const std::size_t comma = std::min(text.find(',', from), text.size());
    const std::string part = text.substr(from, comma - from);
    from = comma + 1;
    const std::size_t equals = part.find('=');
    if (first) {
      request.name = part;
    } else if (equals != std::string::npos) {
      request.values.emplace_back(part.substr(0, equals), part.substr(equals + 1));
    } else if (!request.values.empty()) {
      request.values.back().second += "," + part;
    } else {
      throw UsageError(
          fmt::format("--model {}: found \"{}\" after the name; allowed: key=value", text, part));
    }
  }
  return request;
}

ModelRequest parse_model_words(const std::vector<std::string>& words) {
  ModelRequest request{words[0], {}};
  for (std::size_t k = 1; k < words.size(); ++k) {
    const std::size_t equals = words[k].find('=');
    if (equals == std::string::npos)
      throw UsageError(fmt::format("{}: found \"{}\"; allowed: key=value", words[0], words[k]));
    request.values.emplace_back(words[k].substr(0, equals), words[k].substr(equals + 1));
  }
  return request;
}

Parameters read_parameters(const std::string& what, const std::vector<ParameterInfo>& infos,
                           const KeyValues& values) {
  Parameters parameters;
  std::vector<std::string> names;
  for (const ParameterInfo& info : infos) names.push_back(info.name);
  for (const auto& [key, text] : values) {
    const ParameterInfo* info = find(infos, key);
    if (!info) {
      const std::string hint = suggestion(key, names);
      throw UsageError(fmt::format("{}: key \"{}\": unknown{}; allowed: {}", what, key,
                                   hint.empty() ? "" : ", " + hint,
                                   names.empty() ? "none" : listed(names)));
    }
    try {
      parameters.set(key, parse_value(*info, text));
    } catch (const ParameterError& error) {
      throw UsageError(fmt::format("{}: {}", what, error.what()));
    }
  }
  fill_defaults(infos, parameters);
  return parameters;
}

std::vector<ParameterInfo> parameters_of(const ModelInfo& info, const ModelRequest& request) {
  Parameters selecting;
  for (const auto& [key, text] : request.values) {
    if (info.selector.empty() || key != info.selector) continue;
    try {
      selecting.set(key, parse_value(*find(info.parameters, key), text));
    } catch (const ParameterError& error) {
      throw UsageError(fmt::format("{}: {}", request.name, error.what()));
    }
  }
  return parameters_of(info, selecting);
}

namespace {

const ModelInfo& known_model(const ModelRequest& request) {
  if (const ModelInfo* info = find_or_load_model(request.name)) return *info;
  std::vector<std::string> names;
  for (const ModelInfo& info : models()) names.push_back(info.name);
  const std::string hint = suggestion(request.name, names);
  throw UsageError(fmt::format("model \"{}\": unknown{}; allowed: {}", request.name,
                               hint.empty() ? "" : ", " + hint, listed(names)));
}

}  // namespace

void check_request(const ModelRequest& request) {
  const ModelInfo& info = known_model(request);
  (void)read_parameters(request.name, parameters_of(info, request), request.values);
}

BoundModel bind_model(const ModelRequest& request, const Stack* stack) {
  BoundModel bound;
  bound.info = &known_model(request);
  if (bound.info->needs_stack && !stack)
    throw UsageError(
        fmt::format("{}: key \"stack\": found nothing; allowed: a stack file, - or a "
                    "built-in stack",
                    request.name));
  const std::vector<ParameterInfo> infos = parameters_of(*bound.info, request);
  bound.parameters = read_parameters(request.name, infos, request.values);
  for (const ParameterInfo& info : infos)
    if (!bound.parameters.has(info.name) && info.default_value.empty())
      throw UsageError(fmt::format("{}: key \"{}\": found nothing; allowed: {}", request.name,
                                   info.name, allowed_values(info)));
  if (is_plugin_path(request.name)) bound.object = request.name;
  try {
    bound.model = bound.info->make(bound.parameters, stack);
  } catch (const ParameterError& error) {
    throw UsageError(fmt::format("{}: {}", request.name, error.what()));
  }
  for (const auto& [key, value] : bound.parameters.all()) {
    const auto source = request.sources.find(key);
    const bool given = std::any_of(request.values.begin(), request.values.end(),
                                   [&, &k = key](const auto& v) { return v.first == k; });
    bound.sources[key] = source != request.sources.end() ? source->second
                         : given                         ? "given"
                                                         : "default";
  }
  return bound;
}

std::string request_value(const ParameterValue& value) {
  std::string text = to_text(value);
  std::erase_if(text, [](char c) { return c == '[' || c == ']' || c == '"' || c == ' '; });
  return text;
}

std::vector<std::filesystem::path> objects_of(const std::vector<BoundModel>& models) {
  std::vector<std::filesystem::path> paths;
  for (const BoundModel& m : models)
    if (!m.object.empty()) paths.emplace_back(m.object);
  return paths;
}

std::vector<std::filesystem::path> objects_among(const std::vector<ModelRequest>& requests) {
  std::vector<std::filesystem::path> paths;
  for (const ModelRequest& request : requests)
    if (is_plugin_path(request.name)) paths.emplace_back(request.name);
  return paths;
}

std::vector<std::string> distinct_names(const std::vector<BoundModel>& models) {
  std::vector<std::string> names;
  for (const BoundModel& m : models) {
    int same = 0, before = 0;
    for (const BoundModel& other : models) {
      if (&other == &m) before = same;
      same += other.info == m.info;
    }
    names.push_back(same > 1 ? fmt::format("{}_{}", m.info->name, before) : m.info->name);
  }
  return names;
}

std::vector<std::string> distinct_labels(const std::vector<BoundModel>& models) {
  std::vector<std::string> labels;
  for (const BoundModel& m : models) {
    std::string label = m.info->name;
    for (const auto& [key, value] : m.parameters.all()) {
      bool given = false, differs = false;
      for (const BoundModel& other : models) {
        if (other.info != m.info) continue;
        const auto source = other.sources.find(key);
        given = given || (source != other.sources.end() && source->second == "given");
        differs = differs || !other.parameters.has(key) ||
                  request_value(other.parameters.at(key)) != request_value(value);
      }
      if (given && differs) label += fmt::format(", {}={}", key, request_value(value));
    }
    labels.push_back(std::move(label));
  }
  // Of equal labels every one gets a number.
  std::vector<std::string> distinct;
  for (std::size_t k = 0; k < labels.size(); ++k) {
    const auto same = std::count(labels.begin(), labels.end(), labels[k]);
    const auto before =
        std::count(labels.begin(), labels.begin() + static_cast<std::ptrdiff_t>(k), labels[k]);
    distinct.push_back(same > 1 ? fmt::format("{}, {}", labels[k], before + 1) : labels[k]);
  }
  return distinct;
}

std::string to_request(const BoundModel& model) {
  std::string text = model.info->name;
  for (const auto& [key, value] : model.parameters.all())
    text += fmt::format(",{}={}", key, request_value(value));
  return text;
}

std::string request_text(const ModelRequest& request) {
  std::string text = request.name;
  for (const auto& [key, value] : request.values) text += fmt::format(",{}={}", key, value);
  return text;
}

std::vector<ModelRequest> requests_for(const std::vector<ModelRequest>& requests,
                                       const Stack& stack) {
  if (!requests.empty()) return requests;
  std::vector<ModelRequest> all;
  for (const ModelInfo& info : models())
    if (info.applies_to && info.applies_to(stack)) {
      if (info.alternatives.empty()) {
        all.push_back({info.name, {}});
        continue;
      }
      for (const std::string& choice : find(info.parameters, info.alternatives)->choices)
        all.push_back({info.name, {{info.alternatives, choice}}});
    }
  return all;
}

namespace {

// N of a key that ends in _N; else 0.
int number_of(const std::string& key) {
  const std::size_t at = key.rfind('_') + 1;
  int number = 0;
  const char* end = key.data() + key.size();
  const auto [stop, error] = std::from_chars(key.data() + at, end, number);
  return at > 0 && error == std::errc() && stop == end ? number : 0;
}

}  // namespace

std::vector<std::string> told_parameters(const BoundModel& model) {
  int last = 0;
  for (const auto& [key, source] : model.sources)
    if (source != "default") last = std::max(last, number_of(key));
  std::vector<std::string> told;
  for (const ParameterInfo& info : parameters_of(*model.info, model.parameters))
    if (model.parameters.has(info.name) && number_of(info.name) <= last)
      told.push_back(fmt::format("{} = {} ({})", info.name, to_text(model.parameters.at(info.name)),
                                 model.sources.at(info.name)));
  return told;
}

std::string told_parameters(const BoundModel& model, int indent, int width) {
  std::string text, line;
  const auto end_line = [&](const char* mark) {
    if (!line.empty()) text += fmt::format("{:{}}{}{}\n", "", indent, line, mark);
    line.clear();
  };
  for (const std::string& part : told_parameters(model)) {
    const std::size_t columns = indent + line.size() + 2 + part.size() + 1;
    if (!line.empty() && columns > static_cast<std::size_t>(width)) end_line(",");
    line += (line.empty() ? "" : ", ") + part;
  }
  end_line("");
  return text;
}

double nanoseconds_per_eval(const Model& model) {
  using Clock = std::chrono::steady_clock;
  std::vector<DirectionPair> pairs;
  RandomStream stream(1, 0, StreamPurpose::test);
  for (int k = 0; k < 64; ++k) {
    const auto draw = [&] {
      const double mu = stream.uniform();
      return direction_from_mu_phi(mu, 2 * kPi * stream.uniform());
    };
    const Direction wi = draw();
    pairs.push_back({wi, draw()});
  }
  double sum = 0;
  std::uint64_t evaluations = 0;
  // Of these the time is that of calls with many pairs.
  const bool batched = dynamic_cast<const BatchedModel*>(&model) != nullptr;
  std::vector<Rgb> values(pairs.size());
  const auto start = Clock::now();
  double seconds = 0;
  while (seconds < 0.02) {
    if (batched)
      model.eval(pairs, values, Isa::scalar);
    else
      for (const DirectionPair& pair : pairs) sum += model.eval(pair.wi, pair.wo).g;
    evaluations += pairs.size();
    seconds = std::chrono::duration<double>(Clock::now() - start).count();
  }
  [[maybe_unused]] static volatile double sink;
  sink = sum;  // keeps the loop
  return seconds * 1e9 / static_cast<double>(evaluations);
}

}  // namespace lamella
