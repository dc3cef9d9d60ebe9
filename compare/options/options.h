#pragma once

#include <array>
#include <atomic>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "volume/run/simulation.h"

namespace lamella {

/// Exit statuses of the program.
inline constexpr int kDone = 0, kFailed = 1, kUsage = 2, kInvalidNumbers = 3;

/// Wrong usage or bad input: what() is one line for the user; exit status 2.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A model asked for on the command line: NAME,key=value,...
struct ModelRequest {
  std::string name;
  std::vector<std::pair<std::string, std::string>> values;
};
/// Splits "NAME,key=value,..."; a comma inside a value (albedo=0.9,0.5,0.2) stays with it.
[[nodiscard]] ModelRequest parse_model_request(const std::string& text);

/// What the commands share; every member is an option of the command line.
struct Options {
  std::string stack{};                  ///< name, file or "-"; empty: the default stack
  std::vector<std::string> incident{};  ///< THETA[,PHI] in degrees
  std::uint64_t walks = 1000000;
  std::optional<double> target_error{}, seconds{};
  std::optional<std::uint64_t> max_order{};  ///< of walks; else as the plan chooses
  std::optional<std::uint32_t> thin_from{};  ///< likewise, Thinning::first
  /// Options that were given and that only walks have a use for, such as "--walks".
  std::vector<std::string> walk_options{};
  double tolerance = 1e-6;  ///< of the deterministic solver
  /// Of a run that is repeated: where the solver's refinement ended, be it by the clock.
  struct SolverEnd {
    int nodes;
    std::array<int, 3> modes;  // per colour channel
  };
  std::optional<SolverEnd> solver_end{};
  std::string grid = "16x32";
  std::string estimator = "auto";
  std::uint64_t seed = 1;
  int threads = 0;  ///< 0: all
  std::string isa = "auto";
  bool quiet = false, strict = false, as_is = false, quick = false;
  std::string json{}, html{}, output{};
  std::vector<std::string> only{};         ///< parts of bench; empty: all
  std::optional<double> solver_seconds{};  ///< of bench: for each of the solver's rows
  std::vector<std::string> models{};
  std::optional<double> max_error{};
  std::string pairs{};
  std::vector<std::string> contrasts{};                  ///< of homogenise, factors in [0, 1]
  std::string light = "45,45", environment = "uniform";  ///< of preview
  int size = 192;                                        ///< of preview, pixels
  bool preview = false;                                  ///< compare: with a preview
  std::vector<std::string> sets{};                       ///< of sweep: PATH=VALUES
  std::string of = "compare";                            ///< of sweep: compare or furnace
  bool answer_only = false;          ///< compare: the JSON alone, no folder (for sweep)
  std::string medium = "vmf_flake";  ///< that stands for explicit geometry
  bool medium_given = false, walks_given = false;
};

/// A number as the command line has it, "inf" among them; nothing if the text is anything else.
[[nodiscard]] std::optional<double> parse_number(std::string_view text);
/// A whole number, written in digits or like 1e6.
[[nodiscard]] std::optional<std::uint64_t> parse_whole_number(std::string_view text);

/// The incident directions, in the order given; the default set if there is none. Light from below
/// is refused where the stack is closed there.
[[nodiscard]] std::vector<Direction> incident_directions(const Options& options,
                                                         const Stack& stack);
[[nodiscard]] CellGrid parse_grid(const std::string& text);
/// --walks: digits, or a number like 1e6; at least one walk per batch.
[[nodiscard]] std::uint64_t parse_walks(const std::string& text);
[[nodiscard]] Stack stack_of(const Options& options);
/// --isa, or what `auto` stands for on this machine.
[[nodiscard]] Isa isa_of(const Options& options);
/// The narrowest plan for the stack, with --max-order and --isa.
[[nodiscard]] WalkLimits walk_limits(const Options& options);
[[nodiscard]] Plan plan_of(const Options& options, const Stack& stack);
[[nodiscard]] StopRule stop_rule(const Options& options);

/// Polar angle and azimuth in degrees, rounded to what a user typed.
[[nodiscard]] double theta_degrees(Direction w);
[[nodiscard]] double phi_degrees(Direction w);

/// Set by Ctrl-C once catch_interrupts() was called; a second Ctrl-C kills.
extern std::atomic<bool> interrupted;
void catch_interrupts();

/// Where tables go: stdout, or stderr if the JSON takes stdout, or nowhere with --quiet.
[[nodiscard]] std::FILE* table_stream(const Options& options);

/// Runs one simulation by the stop rule with progress on a terminal; returns the reduced result.
[[nodiscard]] RunResult run_with_progress(Simulation& simulation, const Options& options,
                                          const std::string& label);

}  // namespace lamella
