#pragma once

#include <cstdint>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "compare/judge/model_check.h"
#include "compare/library/library_check.h"
#include "compare/options/options.h"
#include "compare/request/run_monitor.h"

namespace lamella {

/// Exit statuses of the program.
inline constexpr int kDone = 0, kFailed = 1, kUsage = 2, kInvalidNumbers = 3;

/// One function per command of the program; each prints its answer and returns the exit status.
/// Throws UsageError, StackFileError, OutputError or NonFiniteError, which main turns into
/// messages.
int simulate_command(const Options& options);
/// `pictures`, here and below: names of their formats; none: PNG where this build has Cairo.
int compare_command(const Options& options, const std::vector<std::string>& pictures);
/// The same where the truth is a measured material, a file that is_measured_file names.
int compare_with_model_command(const Options& options, const std::vector<std::string>& pictures);
int furnace_command(const Options& options);

/// The answer of a command, and the exit status that goes with it.
struct CommandAnswer {
  nlohmann::ordered_json json;
  int status = kDone;
};
/// The answers of compare and furnace for a stack; nothing is printed and no file written. For
/// points of a sweep.
[[nodiscard]] CommandAnswer compare_answer(const Options& options, const Stack& stack,
                                           const RunMonitor& monitor);
[[nodiscard]] CommandAnswer furnace_answer(const Options& options, const Stack& stack,
                                           const RunMonitor& monitor);

/// Depth profiles in the place of the stack's grids, and the error that this makes.
int homogenise_command(const Options& options);
int bench_command(const Options& options);
/// The parts of bench, in its order: the words of --only.
[[nodiscard]] std::vector<std::string> bench_parts();
int accuracy_command(const Options& options);
int preview_command(const Options& options, const std::vector<std::string>& pictures);
/// preview --shape.
int preview_shape_command(const Options& options, const std::vector<std::string>& pictures);
int sweep_command(const Options& options);
int show_command(const Options& options);
int rerun_command(const Options& options);

/// What ranks of mpirun cost and bring: processor time per walk, messages, bytes, a model.
int scaling_command(const Options& options);

/// Walks of four stacks, with that number of collisions in all, against the solver, cell by cell.
int soak_command(const Options& options, double collisions);

/// Options of `library` beside those that all commands share.
struct LibraryOptions {
  std::string action{};             ///< "build", "verify" or "show"
  std::string folder{};             ///< empty: kLibraryFolder
  std::vector<std::string> only{};  ///< names of entries; empty: all
  std::size_t sample = 3;           ///< entries that verify finds again
  bool all = false, by_walks = false;
};
inline constexpr char kLibraryFolder[] = "lamella-library";
/// The library of reference lobes: built, verified, shown.
int library_command(const Options& options, const LibraryOptions& library);

/// Puts the parts of a divided run together. `paths`: of part files.
int merge_command(const Options& options, const std::vector<std::string>& paths,
                  const std::vector<std::string>& pictures);
/// Walks one by one, into an archive of NumPy arrays, or one of each of many stacks. `stacks`:
/// names or files; none: the default stack.
int samples_command(const Options& options, const std::vector<std::string>& stacks);
/// `format`: mitsuba, pbrt, merl, npz or csv; `size`: small, medium or large, of tensor files.
int export_command(const Options& options, const std::string& format, const std::string& size);
/// Measured materials of other programs' formats as lobes.
int import_command(const Options& options);
int explain_command(const Options& options);
/// The names that a command of lists (models, media, stacks) can show one by one; else none.
[[nodiscard]] std::vector<std::string> listed_names(const std::string& command);
/// `name`: of the one to show; empty: all of them.
int models_command(const Options& options, const std::string& name);
int media_command(const Options& options, const std::string& name);
int stacks_command(const Options& options, const std::string& name);
int measure_command(const Options& options);
/// `name`: of a published figure; empty: lists them.
int reproduce_command(const Options& options, const std::string& name,
                      const std::vector<std::string>& pictures);
/// `words`: the model and its key=value arguments.
int eval_command(const Options& options, const std::vector<std::string>& words);

/// `words`: the kind of grid to make and its key=value arguments; none: lists the kinds.
int grid_command(const Options& options, const std::vector<std::string>& words);

/// Options of `dataset` beside those that all commands share.
struct DatasetOptions {
  int layers = 1, directions = 8;
  std::uint64_t stacks = 0;  ///< 0: as many as the paper's, 4000 of one layer, 12000 of more
  std::string grid = "8x16";
};
/// Random SpongeCake stacks with their orders 2 and up, for training.
int dataset_command(const Options& options, const DatasetOptions& asked);

/// Options of the commands about closed forms, beside those that all commands share.
struct ClosedFormOptions {
  std::vector<std::string> outgoing{};  ///< theta_o in degrees
  std::uint64_t samples = 100000;
  std::string sampling{};  ///< the model whose sampling lobes are fitted
  bool bond = false;       ///< light from everywhere instead of --wi
  bool all = false;        ///< samplers: every row and the times, where no model is named
  std::string norm = "relative", sides = "all";  ///< of fits of models and stacks
  std::string stack{};                           ///< of fit: whose numbers are fitted
  std::vector<std::string> vary{};               ///< of fit: PATH=FROM:TO
};

/// What `check` does at most.
struct CheckOptions {
  int configurations = 24;
  std::uint64_t samples = 20000;       ///< per direction and configuration
  std::string library{};               ///< a folder of reference lobes; empty: none
  std::vector<std::string> entries{};  ///< of it, NAME[,key=value...], that the model stands for
};
/// The same with --quick.
inline const CheckOptions kQuickCheck{.configurations = 5, .samples = 4000};
/// Seconds after which `check` begins no further case, unless --time says otherwise.
inline constexpr double kCheckSeconds = 60;
/// An answer, and its lines for people.
struct CheckAnswer {
  CommandAnswer answer;
  std::string text;
};
/// The answer to a check of a model, named `request` in it. `further`: checks beside the battery.
[[nodiscard]] CheckAnswer check_answer(const ModelInfo& info, const std::string& request,
                                       const std::vector<CheckConfiguration>& configurations,
                                       const Options& options, const CheckOptions& checking,
                                       const RunMonitor& monitor,
                                       const std::vector<CheckLine>& further = {});
/// What of a library a check is held against; nothing without --library. Throws UsageError for what
/// has no use without it.
[[nodiscard]] std::optional<LibraryUse> library_use(const Options& options,
                                                    const CheckOptions& checking);
/// The battery of checks of a model. `words`: the model and its key=value arguments.
int check_command(const Options& options, const CheckOptions& checking,
                  const std::vector<std::string>& words);

/// Variance and largest weight of models' samplers.
int samplers_command(const Options& options, const ClosedFormOptions& closed);
/// SpongeCake's further lobes for a stack, a model's sampling lobes, or fits of models.
int fit_command(const Options& options, const ClosedFormOptions& closed,
                const std::vector<std::string>& pictures);
/// The parameters of closed forms that come nearest to a stack, lobes or a material.
int fit_models_command(const Options& options, const ClosedFormOptions& closed,
                       const std::vector<std::string>& pictures);
/// The numbers of a stack that bring it nearest to another stack, to lobes or to a material.
int fit_stack_command(const Options& options, const ClosedFormOptions& closed,
                      const std::vector<std::string>& pictures);
/// What `tabulate` writes.
struct TabulateOptions {
  std::string of = "fourier";               ///< legendre, fourier or albedo
  int terms = 8;                            ///< of the series
  std::vector<std::string> mu_i{}, mu_o{};  ///< cosines; empty: 1, 0.9 ... 0.1
};
/// Series of a closed form or of a medium's phase function, as CSV. `words`: its name and its
/// key=value arguments.
int tabulate_command(const Options& options, const TabulateOptions& asked,
                     const std::vector<std::string>& words);
/// The albedo that gives a colour. `words`: a model or stack and its key=value arguments, the
/// colour as albedo among them.
int invert_command(const Options& options, const ClosedFormOptions& closed,
                   const std::vector<std::string>& words);
/// The white furnace of models over the whole range of their parameters.
int furnace_sweep_command(const Options& options);

}  // namespace lamella
