#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compare/request/model_request.h"
#include "compare/request/truth_request.h"
#include "volume/walk/incident_law.h"

namespace lamella {

/// The words of the command line: every member is an option. The functions below make from them the
/// typed requests that the commands hand to the rest of the program.
struct Options {
  std::string stack{};                  ///< name, file or "-"; empty: the default stack
  std::string at{};                     ///< U,V or mean: the place on a stack with maps
  std::vector<std::string> incident{};  ///< THETA[,PHI] in degrees
  std::string incident_law{};           ///< of samples: uniform or cosine; empty: `incident`
  std::uint64_t walks = 1000000;
  std::optional<double> target_error{}, seconds{};
  std::optional<std::uint64_t> max_order{};  ///< of walks; else as the plan chooses
  std::optional<std::uint32_t> thin_from{};  ///< Thinning::first of walks; else as the plan chooses
  std::string sampling = "rqmc";             ///< of walks on lanes, rqmc or random
  bool walk_order_1 = false;                 ///< all orders by walks
  std::vector<WalkSetting> walk_settings{};  ///< which of the five above were given
  double tolerance = 1e-4;                   ///< of the deterministic solver
  std::string grid = "16x32";
  std::string estimator = "auto";
  std::uint64_t seed = 1;
  int threads = 0;  ///< 0: all
  std::string isa = "auto";
  bool quiet = false, strict = false, as_is = false, quick = false;
  bool coats = false;       ///< of accuracy: the layerings of a coat alone
  bool spongecake = false;  ///< of accuracy: SpongeCake's further lobes alone
  std::string json{}, html{}, output{};
  std::vector<std::string> only{};         ///< parts of bench; empty: all
  std::optional<double> solver_seconds{};  ///< of bench: for each of the solver's rows
  std::string against{};                   ///< of bench: the JSON of an earlier run
  std::optional<int> rounds{};             ///< of bench; else 3 with `against`, 1 without
  std::vector<std::string> models{};
  std::string truth_model{};  ///< of compare: a closed form in the place of the stack
  std::optional<double> max_error{};
  std::string pairs{};
  std::vector<std::string> contrasts{};                  ///< of homogenise, factors in [0, 1]
  std::string light = "45,45", environment = "uniform";  ///< of preview
  int size = 192;                                        ///< of preview, pixels
  std::string shape{};  ///< of preview: an object to trace paths on; empty: sphere and plane
  int depth = 4;        ///< of preview --shape: surfaces that a path may meet
  int samples = 64;     ///< of preview --shape: per pixel
  bool samples_given = false;
  bool table = false;                  ///< of preview --shape: the truth's table, too
  bool white = false;                  ///< of preview --shape: albedos, substrate and f0 at 1
  std::optional<double> equal_time{};  ///< of preview --shape: seconds for each picture
  bool preview = false;                ///< compare: with a preview
  bool all_figures = false;            ///< of reproduce
  std::string quality = "quick";       ///< of reproduce
  std::vector<std::string> sets{};     ///< of sweep: PATH=VALUES
  std::string of = "compare";          ///< of sweep: compare or furnace
  bool per_bsdf = false;               ///< of samples: a file per stack
  bool lobes = false;                  ///< of samples: cells, not walks
  std::string design{};                ///< of samples: latin:N; empty: a grid
  std::string medium = "vmf_flake";    ///< that stands for explicit geometry
  bool medium_given = false, walks_given = false;
  bool fit = false;                          ///< of measure: also by lobes
  std::string shard{};                       ///< I/N; empty: the whole run
  std::string checkpoint{};                  ///< a file; empty: none
  std::optional<double> checkpoint_every{};  ///< seconds
};

/// The incident directions, in the order given; the default set if there is none. Light from below
/// is refused where the stack is closed there.
[[nodiscard]] std::vector<Direction> incident_directions(const Options& options,
                                                         const Stack& stack);
[[nodiscard]] CellGrid parse_grid(const std::string& text);
/// --walks: digits, or a number like 1e6; at least one walk per batch.
[[nodiscard]] std::uint64_t parse_walks(const std::string& text);
/// STACK, at the place of --at where it has maps. Throws UsageError for such a stack without --at,
/// and for --at mean.
[[nodiscard]] Stack stack_of(const Options& options);
/// The same of another stack, by its name or file.
[[nodiscard]] Stack stack_of(const Options& options, const std::string& name);
/// Throws UsageError for --at where `what` is no stack.
void refuse_place(const Options& options, const std::string& what);
/// STACK as commands take it that know the mean over a map.
struct StackOrMean {
  Stack stack;                  ///< of the mean: its first texel, with the name of the whole
  std::vector<Stack> texels{};  ///< TruthRequest::texels
};
[[nodiscard]] StackOrMean stack_or_mean_of(const Options& options);
/// A set's name, or what `auto` stands for on this machine. Throws UsageError.
[[nodiscard]] Isa parse_isa(const std::string& text);
/// --sampling. Throws UsageError for any other word.
[[nodiscard]] Sampling parse_sampling(const std::string& text);
/// --isa.
[[nodiscard]] Isa isa_of(const Options& options);
/// The truth of a stack, as it was asked for. Throws UsageError where an option does not suit it.
[[nodiscard]] TruthRequest truth_request(const Options& options, const Stack& stack);
/// --wi-distribution. Throws UsageError beside --wi, and for words that are none.
[[nodiscard]] IncidentLaw incident_law_of(const Options& options);
/// Each --model.
[[nodiscard]] std::vector<ModelRequest> model_requests(const Options& options);

}  // namespace lamella
