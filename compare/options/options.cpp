#include "compare/options/options.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "compare/maps/surface_stack.h"
#include "compare/request/errors.h"
#include "compare/request/numbers.h"
#include "compare/request/split_text.h"
#include "compare/request/substrate_model.h"
#include "phase/stack/builtin_stacks.h"

namespace lamella {

constexpr int kMaxCells = 1 << 16;

std::vector<Direction> incident_directions(const Options& options, const Stack& stack) {
  if (options.incident.empty()) return default_directions();
  std::vector<Direction> directions;
  for (const std::string& text : options.incident) {
    const std::size_t comma = text.find(',');
    const auto theta = parse_number(std::string_view(text).substr(0, comma));
    const auto phi =
        comma == std::string::npos ? std::optional(0.0) : parse_number(text.substr(comma + 1));
    if (!theta || !phi || !(*theta >= 0 && *theta <= 180) || !std::isfinite(*phi))
      throw UsageError(fmt::format(
          "--wi: found \"{}\"; allowed: THETA[,PHI] in degrees, THETA in [0, 180]", text));
    directions.push_back(direction_from_degrees(*theta, *phi));
    if (directions.back().z < 0 && !stack.is_open_below())
      throw UsageError(fmt::format(
          "--wi: found \"{}\", light from below, which {}; allowed: THETA in [0, 90]", text,
          stack.substrate ? "meets an opaque substrate" : "cannot come through a half space"));
  }
  return directions;
}

CellGrid parse_grid(const std::string& text) {
  const std::size_t x = text.find('x');
  CellGrid grid;
  const auto read = [&](std::string_view part, int& value) {
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    return error == std::errc{} && end == part.data() + part.size() && value >= 1 && value <= 4096;
  };
  const std::string_view view = text;
  if (x == std::string::npos || !read(view.substr(0, x), grid.mu_cells) ||
      !read(view.substr(x + 1), grid.phi_cells))
    throw UsageError(fmt::format(
        "--grid: found \"{}\"; allowed: MUxPHI, such as 16x32, each from 1 to 4096", text));
  // Every batch has sums of its own: more would be many gigabytes.
  if (grid.mu_cells * grid.phi_cells > kMaxCells)
    throw UsageError(
        fmt::format("--grid: found \"{}\"; allowed: MUxPHI of at most {} cells", text, kMaxCells));
  return grid;
}

std::uint64_t parse_walks(const std::string& text) {
  const auto value = parse_whole_number(text);
  if (!value || *value < kBatches || *value > 1000000000000000)
    throw UsageError(fmt::format(
        "--walks: found \"{}\"; allowed: a whole number from {} (one walk per batch) to 1e15", text,
        kBatches));
  return *value;
}

namespace {

constexpr const char* kMeanPlace = "mean";

// The stack of --at, or of its absence; nothing for the mean.
std::optional<Stack> stack_at_place(const Options& options, const SurfaceStack& surface,
                                    bool has_mean) {
  const std::string allowed = fmt::format("--at U,V, each from 0 to 1{}",
                                          has_mean ? ", or --at mean, the mean over the map" : "");
  if (!surface.has_maps()) {
    // First, as a value that was meant to be a picture (wood.gif) is the nearer fault.
    Stack stack = surface.at(0, 0);
    if (!options.at.empty())
      throw UsageError(
          fmt::format("--at: found \"{}\" for {}, which has no pictures among its "
                      "values; allowed: no --at",
                      options.at, surface.name()));
    return stack;
  }
  if (options.at.empty())
    throw UsageError(fmt::format("{} and no place; allowed: {}", surface.told(), allowed));
  if (options.at == kMeanPlace && has_mean) return std::nullopt;
  const std::vector<std::string> words = split_text(options.at, ',');
  std::vector<double> place;
  for (const std::string& word : words)
    if (const auto value = parse_number(word); value && *value >= 0 && *value <= 1)
      place.push_back(*value);
  if (words.size() != 2 || place.size() != 2)
    throw UsageError(fmt::format("--at: found \"{}\"; allowed: {}", options.at, allowed));
  Stack stack = surface.at(place[0], place[1]);
  stack.name += fmt::format("@{},{}", to_text(place[0]), to_text(place[1]));
  return stack;
}

SurfaceStack surface_of(const Options& options) {
  return SurfaceStack(
      load_mapped_stack(options.stack.empty() ? std::string(kDefaultStack) : options.stack));
}

}  // namespace

Stack stack_of(const Options& options) {
  return *stack_at_place(options, surface_of(options), false);
}

Stack stack_of(const Options& options, const std::string& name) {
  Options of_name = options;
  of_name.stack = name;
  return stack_of(of_name);
}

void refuse_place(const Options& options, const std::string& what) {
  if (!options.at.empty())
    throw UsageError(fmt::format(
        "--at: found \"{}\" beside {}, which is no stack; allowed: with a stack that has pictures "
        "among its values",
        options.at, what));
}

StackOrMean stack_or_mean_of(const Options& options) {
  const SurfaceStack surface = surface_of(options);
  if (auto stack = stack_at_place(options, surface, true)) return {std::move(*stack), {}};
  std::vector<Stack> texels = surface.texels(options.seed);
  for (Stack& texel : texels) texel.name += fmt::format("@{}", kMeanPlace);
  return {texels.front(), texels};
}

Isa parse_isa(const std::string& text) {
  try {
    return isa_from_text(text);
  } catch (const std::invalid_argument& e) {
    throw UsageError(e.what());
  }
}

Sampling parse_sampling(const std::string& text) {
  if (const auto sampling = sampling_from(text)) return *sampling;
  throw UsageError(fmt::format("--sampling: found \"{}\"; allowed: rqmc, random", text));
}

Isa isa_of(const Options& options) { return parse_isa(options.isa); }

TruthRequest truth_request(const Options& options, const Stack& stack) {
  TruthRequest request{.stack = stack};
  request.cells = parse_grid(options.grid);
  request.directions = incident_directions(options, stack);
  request.estimator = parse_estimator(options.estimator);
  request.effort = {options.walks, options.target_error, options.seconds};
  request.limits.max_order = options.max_order;
  if (options.thin_from) request.limits.thinning = Thinning{*options.thin_from};
  request.limits.sampling = parse_sampling(options.sampling);
  if (options.walk_order_1) request.limits.order_one = OrderOne::walked;
  request.given = options.walk_settings;
  request.tolerance = options.tolerance;
  request.seed = options.seed;
  request.isa = isa_of(options);
  return request;
}

IncidentLaw incident_law_of(const Options& options) {
  if (options.incident_law.empty()) return IncidentLaw::fixed;
  if (!options.incident.empty())
    throw UsageError(
        "--wi-distribution: found --wi beside it; allowed: one of them, as w_i is drawn or given");
  if (options.incident_law == "uniform") return IncidentLaw::uniform;
  if (options.incident_law == "cosine") return IncidentLaw::cosine;
  throw UsageError(fmt::format("--wi-distribution: found \"{}\"; allowed: uniform, cosine",
                               options.incident_law));
}

std::vector<ModelRequest> model_requests(const Options& options) {
  std::vector<ModelRequest> requests;
  for (const std::string& text : options.models) requests.push_back(parse_model_request(text));
  return requests;
}

}  // namespace lamella
