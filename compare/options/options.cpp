#include "compare/options/options.h"

#include <fmt/format.h>
#include <unistd.h>

#include <charconv>
#include <cmath>
#include <csignal>

#include "compare/request/substrate_model.h"
#include "phase/stack/builtin_stacks.h"

namespace lamella {

std::atomic<bool> interrupted = false;

constexpr int kMaxCells = 1 << 16;

void catch_interrupts() {
  std::signal(SIGINT, [](int) {
    interrupted = true;
    std::signal(SIGINT, SIG_DFL);
  });
}

std::optional<double> parse_number(std::string_view text) {
  double value = 0;
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<std::uint64_t> parse_whole_number(std::string_view text) {
  std::uint64_t digits = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), digits);
  if (error == std::errc{} && end == text.data() + text.size()) return digits;
  const auto value = parse_number(text);
  if (!value || !(*value >= 0 && *value <= 0x1p53) || *value != std::floor(*value))
    return std::nullopt;
  return static_cast<std::uint64_t>(*value);
}

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

std::vector<Direction> incident_directions(const Options& options, const Stack& stack) {
  std::vector<Direction> directions;
  if (options.incident.empty()) {
    for (const double theta : {0.0, 30.0, 60.0, 80.0})
      directions.push_back(direction_from_degrees(theta, 0));
    return directions;
  }
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

Stack stack_of(const Options& options) {
  return with_surface_model(
      load_stack(options.stack.empty() ? std::string(kDefaultStack) : options.stack));
}

Isa isa_of(const Options& options) {
  try {
    return isa_from_text(options.isa);
  } catch (const std::invalid_argument& e) {
    throw UsageError(e.what());
  }
}

WalkLimits walk_limits(const Options& options) {
  WalkLimits limits{.max_order = options.max_order};
  if (options.thin_from) limits.thinning = Thinning{*options.thin_from};
  return limits;
}

Plan plan_of(const Options& options, const Stack& stack) {
  Plan plan = make_plan(stack, walk_limits(options));
  plan.isa = isa_of(options);
  return plan;
}

StopRule stop_rule(const Options& options) {
  return {options.walks, options.target_error, options.seconds};
}

double theta_degrees(Direction w) {
  const double theta = std::atan2(std::hypot(w.x, w.y), w.z) * 180 / kPi;
  return std::round(theta * 1e9) / 1e9;
}

double phi_degrees(Direction w) {
  if (w.x == 0 && w.y == 0) return 0;
  return std::round(azimuth(w) * 180 / kPi * 1e9) / 1e9;
}

std::FILE* table_stream(const Options& options) { return options.json == "-" ? stderr : stdout; }

RunResult run_with_progress(Simulation& simulation, const Options& options,
                            const std::string& label) {
  const bool show = !options.quiet && isatty(STDERR_FILENO);
  const auto progress = [&](const Progress& p) {
    if (!show) return;
    const double rate = p.walks / std::max(p.seconds, 1e-9);
    double left = (p.of_walks - p.walks) / rate;
    if (options.seconds) left = std::min(left, std::max(0.0, *options.seconds - p.seconds));
    fmt::print(stderr, "\r{}: {:.3g} of {:.3g} walks, {:.3g}/s, {:.0f} s left \x1b[K", label,
               static_cast<double>(p.walks), static_cast<double>(p.of_walks), rate, left);
    std::fflush(stderr);
  };
  catch_interrupts();
  const double seconds = run(simulation, stop_rule(options), progress, &interrupted);
  if (show) fmt::print(stderr, "\r\x1b[K");
  RunResult result = reduce(simulation);
  result.seconds = seconds;
  if (options.target_error && result.walks >= options.walks && !interrupted) {
    const double reached = largest_relative_error(simulation);
    if (reached > *options.target_error)
      fmt::print(stderr,
                 "lamella: warning: {}: relative error {:.2g} after {} walks, short of "
                 "--target-error {}; raise --walks\n",
                 label, reached, result.walks, to_text(*options.target_error));
  }
  return result;
}

}  // namespace lamella
