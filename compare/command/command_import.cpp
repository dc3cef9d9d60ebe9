#include <fmt/format.h>

#include <filesystem>

#include "compare/command/command.h"
#include "compare/exchange/exported.h"
#include "compare/exchange/projected_lobes.h"
#include "compare/exchange/tensor_container.h"
#include "compare/files/content_hash.h"
#include "compare/files/exr_file.h"
#include "compare/files/output_folder.h"
#include "compare/options/progress.h"
#include "compare/report/json_report.h"
#include "compare/report/lobe_set.h"
#include "phase/math/degrees.h"
#include "phase/stack/stack_paths.h"

namespace lamella {

int import_command(const Options& options) {
  using Json = nlohmann::ordered_json;
  if (!options.output.empty()) check_output_file(options.output);
  const std::string bytes = read_format_file(options.stack);
  const std::unique_ptr<Model> model = read_brdf(bytes, options.stack);
  const std::string name = std::filesystem::path(options.stack).stem().string();
  LobeSet set = projected_lobes(*model, measured_info(name), incident_directions(options, Stack{}),
                                parse_grid(options.grid), 3);
  Json answer = json_header("import", options.seed, isa_of(options));
  answer["file"] = options.stack;
  answer["sha256"] = content_hash(bytes);
  answer["bytes"] = bytes.size();
  Json runs = Json::array();
  std::FILE* out = table_stream(options);
  const std::vector<double>& energies = set.energies.front().value;
  for (std::size_t k = 0; k < set.directions.size(); ++k) {
    const double* e = energies.data() + 3 * k;
    runs.push_back({{"mu_i", set.directions[k].z},
                    {"phi_i", phi_degrees(set.directions[k])},
                    {"reflected", {e[0], e[1], e[2]}}});
    if (!options.quiet)
      fmt::print(out, "theta_i {:g}, phi_i {:g}: reflected {:.5f} {:.5f} {:.5f}\n",
                 theta_degrees(set.directions[k]), phi_degrees(set.directions[k]), e[0], e[1],
                 e[2]);
  }
  answer["runs"] = std::move(runs);
  if (!options.output.empty()) {
    const auto folder = std::filesystem::path(options.output).parent_path();
    set.attributes["lamella.source"] = relative_to(options.stack, folder).string();
    set.attributes["lamella.files"] =
        fmt::format("{}  {}\n", content_hash(bytes), relative_to(options.stack, folder).string());
    write_exr(options.output, lobe_image(set));
    if (!options.quiet) fmt::print(out, "wrote {}\n", options.output);
  }
  write_json(answer, options.json);
  return kDone;
}

}  // namespace lamella
