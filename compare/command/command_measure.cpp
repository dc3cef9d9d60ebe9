#include <fmt/format.h>

#include "compare/command/command.h"
#include "compare/files/output_folder.h"
#include "compare/fit/least_squares.h"
#include "compare/judge/smith_difference.h"
#include "compare/nearest/grain_fit.h"
#include "compare/options/progress.h"
#include "compare/report/json_report.h"
#include "compare/request/errors.h"
#include "compare/request/truth_request.h"
#include "phase/math/degrees.h"
#include "phase/stack/stack_file.h"
#include "volume/grains/grain_measure.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

// Realisations that are measured: enough for the scatter between them to be known to 10 %.
constexpr std::uint64_t kRealisations = 64;

Json to_json(const Estimate& e) {
  return {{"value", e.value}, {"standard_error", e.standard_error}};
}

Equivalent equivalent_of(const std::string& name) {
  if (name == "lambert_sphere") return Equivalent::lambert_sphere;
  return name == "sggx" ? Equivalent::sggx : Equivalent::vmf_flake;
}

// S of a surface about z, as stack files have it.
std::array<double, 6> matrix_of(double alpha) { return Sggx::surface_matrix(alpha, {0, 0, 1}); }

void print(std::FILE* out, const Stack& stack, const GrainMeasurement& m) {
  const auto line = [&](const char* what, const Estimate& e, const char* doc) {
    fmt::print(out, "  {:<20} {:>10.5g} +- {:<8.1g} {}\n", what, e.value, e.standard_error, doc);
  };
  fmt::print(out, "{}: {} realisations, {} rays\n", stack.name, m.realisations, m.rays);
  if (stack.grains()->is_bed()) {
    line("filled", m.filled, "share of the volume inside of grains");
    line("exposed", m.exposed, "share of the grains' surface outside of other grains");
    line("surface area", m.surface_area, "1/mm: exposed, per volume outside of grains");
    line("projected, mu = 1", m.projected_area[0],
         "1/mm: density sigma(w), what light along w meets");
    line("projected, mu = 0.5", m.projected_area[1], "1/mm");
    line("projected, mu = 0", m.projected_area[2], "1/mm");
    line("extinction", m.extinction,
         "1/mm: the mean over all directions, a quarter of the surface");
  }
  if (!m.profile.empty()) {
    fmt::print(
        out,
        "\n  profile from the surface inwards (z in mm)\n  {:>12} {:>12} {:>9} {:>9} {:>9} {:>9}\n",
        "from", "to", "packing", "+-", "filled", "+-");
    for (const ProfileSlice& s : m.profile)
      fmt::print(out, "  {:>12.5g} {:>12.5g} {:>9.4f} {:>9.1e} {:>9.4f} {:>9.1e}\n", s.z_from,
                 s.z_to, s.packing.value, s.packing.standard_error, s.filled.value,
                 s.filled.standard_error);
    fmt::print(out, "\n");
  }
  line("passed", m.passed, "share of diffuse light from above that meets no grain");
  if (m.vmf.roughness.value > 0) {
    line("vMF roughness", m.vmf.roughness, "r of the normals that light from above meets first");
    line("SGGX roughness", m.sggx.roughness, "alpha of the same, two-sided");
    const auto s = matrix_of(m.sggx.roughness.value);
    fmt::print(out, "  {:<20} [{:.5g}, {:.5g}, {:.5g}, {:g}, {:g}, {:g}]\n", "SGGX matrix", s[0],
               s[1], s[2], s[3], s[4], s[5]);
  }
  fmt::print(out, "\n  normals by their cosine with z, share per bin\n");
  fmt::print(out, "  {:>14} {:>9} {:>9} {:>9} {:>9} {:>9}\n", "cosine", "surface", "met first",
             "+-", "vMF", "SGGX");
  for (int k = 0; k < kNormalBins; ++k)
    fmt::print(out, "  {:>5.2f} .. {:>5.2f} {:>9.5f} {:>9.5f} {:>9.1e} {:>9.5f} {:>9.5f}\n",
               2.0 * k / kNormalBins - 1, 2.0 * (k + 1) / kNormalBins - 1, m.normals[k].value,
               m.first_normals[k].value, m.first_normals[k].standard_error, m.vmf.first_normals[k],
               m.sggx.first_normals[k]);
}

Json to_json(const GrainMeasurement& m, bool bed) {
  Json out{{"realisations", m.realisations}, {"rays", m.rays}};
  if (bed) {
    out["filled"] = to_json(m.filled);
    out["exposed"] = to_json(m.exposed);
    out["surface_area"] = to_json(m.surface_area);
    out["projected_area"] = Json::array();
    const double cosines[] = {1, 0.5, 0};
    for (std::size_t k = 0; k < m.projected_area.size(); ++k) {
      Json entry{{"mu", cosines[k]}};
      entry.update(to_json(m.projected_area[k]));
      out["projected_area"].push_back(std::move(entry));
    }
    out["extinction"] = to_json(m.extinction);
    out["profile"] = Json::array();
    for (const ProfileSlice& s : m.profile)
      out["profile"].push_back({{"z_from", s.z_from},
                                {"z_to", s.z_to},
                                {"packing", to_json(s.packing)},
                                {"filled", to_json(s.filled)}});
  }
  out["passed"] = to_json(m.passed);
  out["vmf_roughness"] = to_json(m.vmf.roughness);
  out["sggx_roughness"] = to_json(m.sggx.roughness);
  out["sggx_matrix"] = matrix_of(std::max(0.01, m.sggx.roughness.value));
  out["normals"] = Json::array();
  for (int k = 0; k < kNormalBins; ++k)
    out["normals"].push_back({{"cosine_from", 2.0 * k / kNormalBins - 1},
                              {"cosine_to", 2.0 * (k + 1) / kNormalBins - 1},
                              {"surface", m.normals[k].value},
                              {"met_first", m.first_normals[k].value},
                              {"standard_error", m.first_normals[k].standard_error},
                              {"vmf", m.vmf.first_normals[k]},
                              {"sggx", m.sggx.first_normals[k]}});
  return out;
}

// No medium stands for a surface: how far it is from Smith's.
int measure_height_field(const Options& options, const TruthRequest& request) {
  if (options.fit || options.medium_given || !options.output.empty())
    throw UsageError(
        "measure: found --fit, --medium or -o for a height_field, a surface that no medium stands "
        "for; allowed: sphere_bed, packed_sphere_bed, micrograins");
  const RunMonitor monitor = terminal_monitor(options);
  const std::vector<SmithDifference> rows = smith_difference(request, monitor);
  if (monitor.finished) monitor.finished();
  if (!options.quiet)
    fmt::print(table_stream(options), "{}: {} walks per direction on it and on Smith's surface\n{}",
               request.stack.name, request.effort.walks, smith_difference_table(rows));
  Json answer = json_header("measure", request);
  answer["smith"] = Json::array();
  for (const SmithDifference& r : rows)
    answer["smith"].push_back({{"theta_i", theta_degrees(r.wi)},
                               {"order", to_text(r.order)},
                               {"energy_height_field", r.energy_field},
                               {"energy_height_field_error", r.energy_field_error},
                               {"energy_smith", r.energy_smith},
                               {"energy_smith_error", r.energy_smith_error},
                               {"relative_rmse", r.cells.rmse},
                               {"relative_noise", r.cells.noise}});
  write_json(answer, options.json);
  return kDone;
}

}  // namespace

int measure_command(const Options& options) {
  const TruthRequest request = truth_request(options, stack_of(options));
  const Stack& stack = request.stack;
  if (!stack.grains())
    throw UsageError(fmt::format(
        "measure: found the stack \"{}\" of media; allowed: explicit geometry (sphere_bed, "
        "packed_sphere_bed, micrograins), whose medium is to be found",
        stack.name));
  if (stack.grains()->is_height_field()) return measure_height_field(options, request);
  if (!options.fit && (!options.incident.empty() || options.grid != Options{}.grid))
    throw UsageError("measure: found --wi or --grid without --fit; allowed: beside it");
  if (options.fit) require_least_squares();
  if (!options.output.empty()) check_output_file(options.output);
  const GrainMeasurement m =
      measure_grains(*stack.grains(), options.seed, kRealisations,
                     std::max<std::uint64_t>(1, options.walks / kRealisations));
  std::FILE* out = table_stream(options);
  if (!options.quiet) print(out, stack, m);
  Json answer = json_header("measure", request);
  answer["measured"] = to_json(m, stack.grains()->is_bed());
  std::string text, reason;
  try {
    Stack medium = equivalent_stack(stack, m, equivalent_of(options.medium));
    if (options.fit) {
      const RunMonitor monitor = terminal_monitor(options);
      const GrainFit fit = fit_grains(request, medium, monitor);
      if (monitor.finished) monitor.finished();
      if (!options.quiet) fmt::print(out, "\n{}", grain_fit_table(fit));
      answer["fit"] = grain_fit_json(fit);
      medium = parse_stack(fit.medium.fits.front().stack, "equivalent", medium.name);
    }
    text = to_toml(medium);
    answer["equivalent"] = to_json(medium);
  } catch (const std::invalid_argument& error) {
    if (!options.output.empty() || options.medium_given || options.fit)
      throw UsageError(fmt::format("measure: {}", error.what()));
    reason = error.what();
  }
  if (!options.quiet) {
    if (text.empty())
      fmt::print(out, "\nno equivalent stack: {}\n", reason);
    else
      fmt::print(out, "\nequivalent stack{}:\n\n{}",
                 options.output.empty() ? "" : " (written to " + options.output + ")", text);
  }
  if (!options.output.empty()) write_file(options.output, text);
  write_json(answer, options.json);
  return kDone;
}

}  // namespace lamella
