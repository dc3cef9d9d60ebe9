#include "compare/command/fit_folder.h"

#include <fmt/format.h>

#include "compare/command/picture_options.h"
#include "compare/files/output_folder.h"
#include "compare/options/progress.h"
#include "compare/report/comparison_report.h"
#include "compare/report/json_report.h"
#include "compare/report/report_page.h"

namespace lamella {

void write_fit_folder(const Options& options, const FitComparison& found,
                      const nlohmann::ordered_json& answer, const std::string& summary,
                      const std::string& about) {
  const std::string& folder = options.output;
  const TruthRequest& request = found.target.request;
  (void)write_comparison_files(folder, request, found.comparison, found.formats, found.inputs);
  nlohmann::ordered_json report = comparison_json(request, found.comparison);
  add_files(report, found.inputs);
  write_json(report, folder + "/report.json");
  write_json(answer, folder + "/fit.json");
  write_file(folder + "/summary.txt",
             summary + "\n" + comparison_summary(request, found.comparison));
  write_report_page(folder + "/report.html", request.stack.name + ": " + about, report,
                    comparison_details(found.comparison));
  if (!options.quiet)
    fmt::print(table_stream(options), "\nwrote {}/: report.html to look at, fit.json\n{}", folder,
               absent_pictures_text());
}

}  // namespace lamella
