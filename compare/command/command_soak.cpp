#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <iterator>
#include <memory>

#include "compare/command/command.h"
#include "compare/command/divided_run.h"
#include "compare/files/folder_lock.h"
#include "compare/files/output_folder.h"
#include "compare/judge/lobe_sums.h"
#include "compare/library/library_stacks.h"
#include "compare/options/progress.h"
#include "compare/report/json_report.h"
#include "compare/request/errors.h"
#include "compare/request/interrupt.h"
#include "compare/shards/merged_keeper.h"
#include "compare/truth/ground_truth.h"
#include "phase/math/degrees.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

// With a coat, fibers, vMF flakes, Henyey-Greenstein: stacks of the library.
constexpr const char* kStacks[] = {"wet_spheres", "fiber_slab", "vmf_halfspace", "hg_slab"};
constexpr const char* kDirections[] = {"30", "75"};
constexpr double kSolverTolerance = 1e-6, kSolverSeconds = 300;
constexpr std::uint64_t kPilotWalks = 1 << 14;
// The probability that a soak without any error fails.
constexpr double kSoakFalseAlarm = 1e-3;
constexpr double kTails[] = {2, 3, 4};

// The deviations of one lobe of one stack, over directions, cells and channels.
struct SoakRow {
  std::string stack, side, order;
  std::vector<double> z{};
  std::size_t left_out = 0;  // cells of less than kPooledEvents effective events

  [[nodiscard]] double rms() const {
    double sum = 0;
    for (const double x : z) sum += x * x;
    return z.empty() ? 0 : std::sqrt(sum / static_cast<double>(z.size()));
  }
  [[nodiscard]] double mean() const {
    double sum = 0;
    for (const double x : z) sum += x;
    return z.empty() ? 0 : sum / static_cast<double>(z.size());
  }
  [[nodiscard]] double most() const {
    double most = 0;
    for (const double x : z) most = std::max(most, std::abs(x));
    return most;
  }
  [[nodiscard]] std::size_t beyond(double limit) const {
    return static_cast<std::size_t>(
        std::count_if(z.begin(), z.end(), [&](double x) { return std::abs(x) > limit; }));
  }
};

Options walk_options(const Options& options, std::uint64_t walks) {
  Options of_walks = options;
  of_walks.incident.assign(std::begin(kDirections), std::end(kDirections));
  of_walks.walks = walks;
  of_walks.walks_given = true;
  of_walks.walk_settings = {WalkSetting::walks};
  of_walks.estimator = to_text(Estimator::analog);
  of_walks.grid = "8x16";
  of_walks.walk_order_1 = true;  // it is what is tested
  return of_walks;
}

std::vector<RunResult> runs_of(const TruthRequest& request, const RunMonitor& monitor) {
  GroundTruth truth(request, Estimator::analog, monitor);
  std::vector<RunResult> runs;
  for (std::size_t k = 0; truth.goes_on(k); ++k) runs.push_back(truth.find(k).run);
  return runs;
}

// The number of walks per direction that makes the collisions of all directions, by a few walks.
std::uint64_t walks_for(const Options& options, const Stack& stack, double collisions) {
  double few = 0;
  for (const RunResult& run : runs_of(truth_request(walk_options(options, kPilotWalks), stack), {}))
    few += static_cast<double>(run.collisions);
  const double walks = collisions / few * static_cast<double>(kPilotWalks);
  return kBatches * std::max<std::uint64_t>(1, static_cast<std::uint64_t>(walks / kBatches));
}

void add_lobe(SoakRow& row, std::string& csv, const RunResult& walked, const RunResult& solved,
              const LobeEstimate& walk, const LobeEstimate& exact) {
  const auto to = std::back_inserter(csv);
  const std::size_t cells = walked.grid.cells();
  for (std::size_t k = 0; k < walk.value.size(); ++k) {
    const double error = walk.standard_error[k], bound = exact.standard_error[k];
    const bool counts = error > 0 && walk.value[k] * walk.value[k] >= kPooledEvents * error * error;
    const double z = counts ? (walk.value[k] - exact.value[k]) / std::hypot(error, bound) : 0;
    if (counts)
      row.z.push_back(z);
    else
      ++row.left_out;
    fmt::format_to(to, "{},{:g},{},{},{},{},{},{:.9g},{:.3g},{:.9g},{:.3g},{}\n", row.stack,
                   theta_degrees(solved.incident), row.side, row.order,
                   k % cells / walked.grid.columns(), k % cells % walked.grid.columns(), k / cells,
                   walk.value[k], error, exact.value[k], bound,
                   counts ? fmt::format("{:.4f}", z) : "");
  }
}

// The rows of one stack, and lines of CSV.
std::vector<SoakRow> compared(const std::string& name, const std::vector<RunResult>& walked,
                              const std::vector<RunResult>& solved, std::string& csv) {
  std::vector<SoakRow> rows;
  for (const bool reflected : {true, false})
    for (int o = 0; o < kLobeOrders; ++o) {
      SoakRow row{name, reflected ? "reflect" : "transmit", to_text(static_cast<Order>(o))};
      for (std::size_t d = 0; d < walked.size(); ++d) {
        const auto side = [&](const RunResult& run) -> const SideResult& {
          return reflected ? run.reflected : run.transmitted;
        };
        const LobeEstimate& walk = side(walked[d]).lobes[o];
        const LobeEstimate& exact = side(solved[d]).lobes[o];
        if (walk.value.empty() || exact.value.size() != walk.value.size()) continue;
        add_lobe(row, csv, walked[d], solved[d], walk, exact);
      }
      if (!row.z.empty()) rows.push_back(std::move(row));
    }
  return rows;
}

double beyond_in_theory(double limit) {
  return 2 *
         boost::math::cdf(boost::math::complement(boost::math::students_t(kBatches - 1), limit));
}

std::string table_of(const std::vector<SoakRow>& rows) {
  std::string text =
      fmt::format("{:<14} {:<9} {:<5} {:>6} {:>8} {:>7} {:>6} {:>7} {:>7} {:>7}\n", "stack", "side",
                  "order", "cells", "left out", "mean z", "rms z", "|z| > 2", "|z| > 3", "largest");
  for (const SoakRow& row : rows)
    text += fmt::format("{:<14} {:<9} {:<5} {:>6} {:>8} {:>7.3f} {:>6.3f} {:>7} {:>7} {:>7.2f}\n",
                        row.stack, row.side, row.order, row.z.size(), row.left_out, row.mean(),
                        row.rms(), row.beyond(2), row.beyond(3), row.most());
  return text;
}

}  // namespace

int soak_command(const Options& given, double collisions) {
  Options options = given;
  const fs::path folder = options.output.empty() ? "lamella-soak" : options.output;
  options.isa = to_text(isa_of(options));
  make_output_folder(folder);
  const FolderLock lock(folder);
  const RunMonitor monitor = terminal_monitor(options);
  std::FILE* out = table_stream(options);
  std::vector<SoakRow> rows;
  std::string csv = "stack,theta_i,side,order,row,column,channel,f_walks,se,f_solver,bound,z\n";
  std::uint64_t done = 0;
  Json stacks = Json::array();
  for (const LibraryStack& of : library_stacks()) {
    if (std::find(std::begin(kStacks), std::end(kStacks), of.name) == std::end(kStacks)) continue;
    const std::uint64_t walks =
        walks_for(options, of.stack, collisions / static_cast<double>(std::size(kStacks)));
    TruthRequest exact = truth_request(walk_options(options, walks), of.stack);
    exact.estimator = Estimator::deterministic;
    exact.given.clear();
    exact.tolerance = kSolverTolerance;
    exact.effort.seconds = kSolverSeconds;
    const std::vector<RunResult> solved = runs_of(exact, monitor);
    const DividedRun run{"simulate", walk_options(options, walks), of.stack};
    const std::string checkpoint = (folder / (of.name + ".checkpoint")).string();
    const PartWork work =
        find_part(simulate_divided(), run, {}, checkpoint, monitor, options.quiet);
    const SentPieces found(of.name, loaded(work.pieces));
    MergedKeeper keeper(std::vector<const Pieces*>{&found});
    const std::vector<RunResult> walked =
        runs_of(truth_request(run.options, of.stack), {.keeper = &keeper});
    std::uint64_t own = 0;
    for (const RunResult& r : walked) own += r.collisions;
    done += own;
    double bound = 0;
    for (const RunResult& r : solved) bound = std::max(bound, r.accuracy->error);
    for (SoakRow& row : compared(of.name, walked, solved, csv)) rows.push_back(std::move(row));
    stacks.push_back(
        {{"name", of.name}, {"walks", walks}, {"collisions", own}, {"solver_bound", bound}});
    if (!options.quiet)
      fmt::print(out,
                 "{}: {:.3g} collisions of {:.3g} walks per direction, the solver within {:.1e}\n",
                 of.name, static_cast<double>(own), static_cast<double>(walks), bound);
    std::fflush(out);
  }
  std::size_t cells = 0;
  double most = 0;
  for (const SoakRow& row : rows) {
    cells += row.z.size();
    most = std::max(most, row.most());
  }
  // Bonferroni's bound holds whatever the cells have in common.
  const double p = std::min(1.0, beyond_in_theory(most) * static_cast<double>(cells));
  const bool failed = p < kSoakFalseAlarm;
  std::string summary = table_of(rows) + "\n";
  Json tails = Json::array();
  for (const double limit : kTails) {
    std::size_t count = 0;
    for (const SoakRow& row : rows) count += row.beyond(limit);
    const double expected = beyond_in_theory(limit) * static_cast<double>(cells);
    summary += fmt::format("|z| > {:g}: {} of {} cells, {:.1f} by Student's t\n", limit, count,
                           cells, expected);
    tails.push_back({{"limit", limit}, {"cells", count}, {"expected", expected}});
  }
  summary += fmt::format("{}: {:.3g} collisions, largest |z| {:.2f}, p = {:.2g} of all cells\n",
                         failed ? "fail" : "pass", static_cast<double>(done), most, p);
  write_file(folder / "z.csv", csv);
  write_file(folder / "summary.txt", summary);
  if (!options.quiet)
    fmt::print(out, "\n{}wrote {}/: z.csv, summary.txt\n", summary, folder.string());
  Json answer = json_header("soak", options.seed, isa_of(options));
  answer["verdict"] = failed ? "fail" : "pass";
  answer["collisions"] = done;
  answer["p_value"] = p;
  answer["largest_z"] = most;
  answer["stacks"] = std::move(stacks);
  answer["tails"] = std::move(tails);
  answer["lobes"] = Json::array();
  for (const SoakRow& row : rows)
    answer["lobes"].push_back({{"stack", row.stack},
                               {"side", row.side},
                               {"order", row.order},
                               {"cells", row.z.size()},
                               {"left_out", row.left_out},
                               {"mean_z", row.mean()},
                               {"rms_z", row.rms()},
                               {"largest_z", row.most()}});
  write_json(answer, options.json);
  return failed ? kFailed : kDone;
}

}  // namespace lamella
