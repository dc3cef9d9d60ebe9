#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <sstream>

#include "compare/command/command.h"
#include "compare/command/texel_models.h"
#include "compare/judge/judgement.h"
#include "compare/options/progress.h"
#include "compare/report/json_report.h"
#include "compare/report/lobe_files.h"
#include "compare/report/texel_record.h"
#include "compare/request/errors.h"
#include "compare/request/model_request.h"
#include "compare/request/numbers.h"
#include "compare/request/run_monitor.h"
#include "compare/request/stack_parameters.h"
#include "compare/request/substrate_model.h"
#include "compare/request/truth_request.h"
#include "compare/truth/ground_truth.h"
#include "phase/stack/stack_file.h"
#include "phase/stack/stack_paths.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;

// What a file says of the run that made it.
struct RecordedRun {
  TruthRequest request;  // as it was asked for
  Estimator estimator;   // that found it
  std::vector<std::uint64_t> walks;
  std::string model;           // empty: the lobes of the truth alone
  std::string model_asked{};   // of a mean over a map: what every texel's was asked for by
  Stack found{};               // the request's stack, its files where they are now
  std::string model_object{};  // path of the shared object that the model comes from
};

const std::string& attribute(const ExrImage& image, const std::string& path,
                             const std::string& name) {
  const auto found = image.attributes.find("lamella." + name);
  if (found == image.attributes.end())
    throw UsageError(
        fmt::format("{}: found no attribute lamella.{}; allowed: a file of lobes that "
                    "lamella simulate or compare wrote",
                    path, name));
  return found->second;
}

std::string attribute_or_nothing(const ExrImage& image, const std::string& name) {
  const auto found = image.attributes.find("lamella." + name);
  return found == image.attributes.end() ? "" : found->second;
}

RecordedRun recorded_run(const ExrImage& image, const std::string& path) {
  const auto text = [&](const std::string& name) { return attribute(image, path, name); };
  const auto broken = [&](const std::string& name) {
    return UsageError(fmt::format("{}: found lamella.{} = \"{}\"; allowed: what lamella writes",
                                  path, name, text(name)));
  };
  const auto whole = [&](const std::string& name) {
    const auto value = parse_whole_number(text(name));
    if (!value) throw broken(name);
    return *value;
  };
  const auto estimator = [&](const std::string& name) {
    try {
      return parse_estimator(text(name));
    } catch (const UsageError&) {
      throw broken(name);
    }
  };
  if (text("stack").empty())
    throw UsageError(
        fmt::format("{}: its truth was a measured material or a closed form, which is nothing to "
                    "repeat; allowed: lobes of a stack",
                    path));
  TexelRecord texels = read_texels(image, path);
  RecordedRun recorded{.request = {}, .estimator = Estimator::analog, .walks = {}, .model = {}};
  TruthRequest& request = recorded.request;
  request.stack = with_surface_model(parse_stack(text("stack"), path, text("stack_name")));
  request.texels = std::move(texels.texels);
  request.texel_ends = std::move(texels.ends);
  request.cells = parse_grid(text("grid"));
  request.seed = whole("seed");
  request.limits.max_order = whole("max_order");
  // Before there was thinning nothing was thinned.
  request.limits.thinning = Thinning{image.attributes.contains("lamella.thin_from")
                                         ? static_cast<std::uint32_t>(whole("thin_from"))
                                         : 0};
  // Before there was a choice all numbers were random.
  request.limits.sampling = image.attributes.contains("lamella.sampling")
                                ? parse_sampling(text("sampling"))
                                : Sampling::random;
  // Before order 1 could be exact it was walked.
  request.limits.order_one = OrderOne::walked;
  if (image.attributes.contains("lamella.order_1")) {
    const auto order_one = order_one_from(text("order_1"));
    if (!order_one) throw broken("order_1");
    request.limits.order_one = *order_one;
  }
  request.isa = parse_isa(text("isa"));
  request.estimator = estimator("estimator_asked");
  const std::optional<Estimator> used = estimator("estimator");
  if (!used) throw broken("estimator");
  recorded.estimator = *used;
  if (recorded.estimator == Estimator::deterministic) {
    const auto tolerance = parse_number(text("tolerance"));
    if (!tolerance || !(*tolerance > 0)) throw broken("tolerance");
    request.tolerance = *tolerance;
    std::array<int, 3> modes{};
    std::istringstream words(text("modes"));
    for (int& count : modes)
      if (!(words >> count) || count < 1) throw broken("modes");
    request.solver_end = {static_cast<int>(whole("nodes")), modes, std::nullopt};
    if (image.attributes.contains("lamella.integrated_from"))
      request.solver_end->integrated_from = static_cast<int>(whole("integrated_from"));
  }
  std::istringstream directions(text("directions")), walks(text("walks"));
  request.directions.clear();
  for (std::string word; directions >> word;) {
    Direction w;
    double* const parts[] = {&w.x, &w.y, &w.z};
    std::size_t from = 0;
    for (double* part : parts) {
      const std::size_t comma = std::min(word.find(',', from), word.size());
      const auto value = parse_number(word.substr(from, comma - from));
      if (!value) throw broken("directions");
      *part = *value;
      from = std::min(comma + 1, word.size());
    }
    request.directions.push_back(w);
  }
  for (std::string word; walks >> word;) {
    const auto value = parse_whole_number(word);
    if (!value) throw broken("walks");
    recorded.walks.push_back(*value);
  }
  if (request.directions.empty() || recorded.walks.size() != request.directions.size())
    throw broken("walks");
  // Whole batches of each texel, unless something stopped them.
  for (const std::uint64_t count : recorded.walks)
    if (!request.texels.empty() && recorded.estimator != Estimator::deterministic &&
        (count == 0 || count % (kBatches * request.texels.size()) != 0))
      throw UsageError(fmt::format(
          "{}: its {} walks ended before each of {} texels had as many as the others; allowed: a "
          "mean over a map that was not interrupted",
          path, count, request.texels.size()));
  recorded.found = with_found_files(request.stack, attribute_or_nothing(image, "files"),
                                    fs::path(path).parent_path(), path);
  recorded.model = attribute_or_nothing(image, "model");
  recorded.model_asked = attribute_or_nothing(image, "model_asked");
  // With a slash, so that it is a path whatever its name is.
  if (const std::string file = attribute_or_nothing(image, "model_file"); !file.empty())
    recorded.model_object =
        (fs::path(".") / find_recorded(file, attribute_or_nothing(image, "files"),
                                       fs::path(path).parent_path(), path))
            .string();
  return recorded;
}

struct RepeatedRun {
  ExrImage image;  // its files named as the recorded one names them
  InputFiles inputs;
};

RepeatedRun repeated(const RecordedRun& recorded, const RunMonitor& monitor) {
  // Walks are repeated as they were, not chosen again; what asked for them is kept in the header.
  TruthRequest request = recorded.request;
  if (recorded.estimator != Estimator::deterministic) request.estimator = recorded.estimator;
  request.stack = recorded.found;
  std::vector<fs::path> objects;
  if (!recorded.model_object.empty()) objects.emplace_back(recorded.model_object);
  InputFiles inputs(recorded.found, objects);
  GroundTruth truth(request, recorded.estimator, monitor);
  std::optional<BoundModel> model;
  if (!recorded.model.empty()) {
    const bool of_texels = !recorded.model_asked.empty();
    ModelRequest asked = parse_model_request(of_texels ? recorded.model_asked : recorded.model);
    if (!recorded.model_object.empty()) asked.name = recorded.model_object;
    if (of_texels)
      model = std::move(
          models_of_texels({asked}, request.texels, recorded.estimator == Estimator::deterministic)
              .front());
    else
      model = model_for(asked, request.stack);
  }
  std::vector<RunResult> runs, map_errors;
  std::vector<LobeComparison> lobes;
  for (std::size_t k = 0; k < request.directions.size(); ++k) {
    const Truth found = truth.find(k, recorded.walks[k]);
    runs.push_back(found.run);
    if (found.map_error) map_errors.push_back(*found.map_error);
    if (monitor.is_stopped()) throw UsageError("interrupted: nothing is said of the file");
    if (!model) continue;
    for (LobeComparison& l : judge(found, truth.plan(), *model)) lobes.push_back(std::move(l));
  }
  inputs.check();
  ExrImage image = model ? comparison_image(recorded.request, runs, lobes, recorded.model)
                         : simulation_image(recorded.request, runs);
  if (!model) add_map_errors(image, map_errors);
  if (!recorded.model_asked.empty()) image.attributes["lamella.model_asked"] = recorded.model_asked;
  record_texels(image, recorded.request, truth.texel_ends());
  return {std::move(image), std::move(inputs)};
}

// Names the files of a repeated run for its place, which need not be that of the first one.
void name_for(ExrImage& image, const RecordedRun& recorded, const InputFiles& inputs,
              const fs::path& folder) {
  image.attributes["lamella.stack"] = to_toml(with_files_relative_to(recorded.found, folder));
  if (!recorded.model_object.empty())
    image.attributes["lamella.model_file"] = relative_to(recorded.model_object, folder).string();
  record_files(image, inputs, folder);
}

}  // namespace

int rerun_command(const Options& options) {
  ExrImage was = read_exr(options.stack);
  const RecordedRun recorded = recorded_run(was, options.stack);
  auto [is, inputs] = repeated(recorded, terminal_monitor(options));
  const auto by_name = [](const auto& a, const auto& b) { return a.first < b.first; };
  std::sort(was.channels.begin(), was.channels.end(), by_name);
  std::sort(is.channels.begin(), is.channels.end(), by_name);
  std::vector<std::string> differences;
  for (const auto& [name, value] : was.attributes) {
    // Found again by their content, wherever they lie now.
    if (name == "lamella.files" || name == "lamella.model_file") continue;
    const auto found = is.attributes.find(name);
    if (found == is.attributes.end() || found->second != value)
      differences.push_back("attribute " + name);
  }
  double largest = 0;
  for (const auto& [name, values] : was.channels) {
    const auto found = std::find_if(is.channels.begin(), is.channels.end(),
                                    [&, &n = name](const auto& c) { return c.first == n; });
    if (found == is.channels.end() || found->second.size() != values.size()) {
      differences.push_back("channel " + name);
      continue;
    }
    if (std::memcmp(found->second.data(), values.data(), values.size() * sizeof(float)) == 0)
      continue;
    differences.push_back("channel " + name);
    for (std::size_t k = 0; k < values.size(); ++k)
      largest = std::max(largest, std::abs(static_cast<double>(values[k]) - found->second[k]));
  }
  if (!options.output.empty()) {
    name_for(is, recorded, inputs, fs::path(options.output).parent_path());
    write_exr(options.output, is);
  }
  std::FILE* out = table_stream(options);
  if (!options.quiet) {
    if (differences.empty())
      fmt::print(out, "{}: the same bit for bit: {} channels\n", options.stack,
                 was.channels.size());
    else
      fmt::print(out, "{}: differs in {} places, first {}; largest difference of a value {:g}\n",
                 options.stack, differences.size(), differences.front(), largest);
    if (!options.output.empty()) fmt::print(out, "wrote {}\n", options.output);
  }
  write_json({{"format", 1},
              {"command", "rerun"},
              {"version", LAMELLA_VERSION},
              {"same", differences.empty()},
              {"differences", differences},
              {"largest_difference", largest}},
             options.json);
  return differences.empty() ? kDone : kFailed;
}

}  // namespace lamella
