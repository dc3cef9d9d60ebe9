#include <fmt/format.h>

#include "compare/command/command.h"
#include "compare/files/output_folder.h"
#include "compare/preview/preview_views.h"
#include "compare/report/json_report.h"

namespace lamella {

int preview_command(const Options& options) {
  const Stack stack = stack_of(options);
  check_preview("preview", stack);
  const PreviewLighting lighting = preview_lighting(options);
  const std::vector<BoundModel> models = models_for(options, stack);
  const std::string folder = options.output.empty() ? stack.name + "-preview" : options.output;
  make_output_folder(folder);
  catch_interrupts();
  const LobeTable table = LobeTable::make(stack, options);
  std::FILE* out = table_stream(options);
  if (!options.quiet) fmt::print(out, "{}: truth by {}\n", stack.name, table.source());
  const std::vector<PreviewResult> views =
      preview_views(table, models, distinct_names(models), lighting, options.size);
  write_preview_files(folder + "/", views, table, stack, options);
  nlohmann::ordered_json answer = json_header("preview", stack, options);
  answer["truth"] = table.source();
  answer["interrupted"] = interrupted.load();
  answer["views"] = to_json(views);
  if (!options.quiet)
    fmt::print(out, "{}wrote {}/: an EXR and a PNG per view\n", preview_table(views), folder);
  write_json(answer, options);
  return kDone;
}

}  // namespace lamella
