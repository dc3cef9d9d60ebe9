#include <fmt/format.h>

#include <algorithm>

#include "analytic/catalogue/model_plugin.h"
#include "compare/command/command.h"
#include "compare/judge/model_configurations.h"
#include "compare/options/progress.h"
#include "compare/report/check_report.h"
#include "compare/report/json_report.h"
#include "compare/report/report_page.h"
#include "compare/report/wrapped_text.h"
#include "compare/request/errors.h"
#include "compare/request/model_file.h"
#include "compare/request/model_request.h"
#include "compare/request/substrate_model.h"
#include "phase/stack/builtin_stacks.h"

namespace lamella {
namespace {

// The stack that stack=... names; the key is taken out of the request.
std::optional<Stack> take_stack(ModelRequest& request) {
  const auto key = std::find_if(request.values.begin(), request.values.end(),
                                [](const auto& v) { return v.first == "stack"; });
  if (key == request.values.end()) return std::nullopt;
  if (key->second.empty())
    throw UsageError(
        fmt::format("{}: key \"stack\": found \"\"; allowed: a stack file, - or a built-in stack",
                    request.name));
  std::optional<Stack> stack = with_surface_model(load_stack(key->second));
  request.values.erase(key);
  return stack;
}

// "NAME,key=value,..." or "@FILE", then key=value words.
ModelRequest request_of(const std::vector<std::string>& words) {
  ModelRequest request = parse_model_request(model_text(words.front()));
  std::vector<std::string> further(words);
  further.front() = request.name;
  for (const auto& value : parse_model_words(further).values) request.values.push_back(value);
  return request;
}

}  // namespace

CheckAnswer check_answer(const ModelInfo& info, const std::string& request,
                         const std::vector<CheckConfiguration>& configurations,
                         const Options& options, const CheckOptions& checking,
                         const RunMonitor& monitor, const std::vector<CheckLine>& further) {
  const ModelCheckSettings settings{.lobes = static_cast<int>(info.lobes.size()),
                                    .reciprocal = info.reciprocal,
                                    .transmits = info.transmits,
                                    .samples = checking.samples,
                                    .seed = options.seed,
                                    .seconds = options.seconds.value_or(kCheckSeconds),
                                    .few_angles = options.quick,
                                    .stop = [&] { return monitor.is_stopped(); }};
  ModelCheck check = check_model(configurations, settings);
  check.lines.insert(check.lines.end(), further.begin(), further.end());
  const std::string refused =
      check.refused ? fmt::format(", {} refused", check.refused) : std::string();
  std::string text =
      wrapped("", fmt::format("{}: {}; {} of {} configurations{}{}", request,
                              check.failed() ? "fail" : "pass", check.configurations,
                              configurations.size(), refused,
                              check.single_precision ? "; values in single precision" : "")) +
      to_text(check);
  if (check.ended_by_time)
    text +=
        fmt::format("  Ended by time, after {} s (--time): cases are missing.\n", settings.seconds);
  CommandAnswer answer{json_header("check", options.seed, isa_of(options)),
                       check.failed() ? kFailed : kDone};
  answer.json["request"] = request;
  answer.json.update(to_json(check));
  answer.json["configurations_planned"] = configurations.size();
  return {std::move(answer), std::move(text)};
}

std::optional<LibraryUse> library_use(const Options& options, const CheckOptions& checking) {
  if (!checking.library.empty())
    return LibraryUse{checking.library, checking.entries,
                      options.max_error.value_or(kLibraryMaxError)};
  if (!checking.entries.empty() || options.max_error)
    throw UsageError("--entry and --max-error: found no --library; allowed: beside it");
  return std::nullopt;
}

int check_command(const Options& options, const CheckOptions& checking,
                  const std::vector<std::string>& words) {
  ModelRequest request = request_of(words);
  const ModelInfo* found = find_or_load_model(request.name);
  std::optional<Stack> stack;
  if (found && found->needs_stack) stack = take_stack(request);
  const InputFiles inputs(stack.value_or(Stack{}), objects_among({request}));
  check_request(request);
  const ModelInfo& info = *find_or_load_model(request.name);
  const CheckOptions effort =
      options.quick ? CheckOptions{std::min(kQuickCheck.configurations, checking.configurations),
                                   std::min(kQuickCheck.samples, checking.samples),
                                   {},
                                   {}}
                    : checking;
  const RunMonitor monitor = terminal_monitor(options);
  std::vector<CheckLine> on_library;
  if (const auto use = library_use(options, checking))
    on_library = check_on_library(request, *use, monitor);
  auto [answer, text] = check_answer(
      info, to_request(request),
      configurations_to_check(info, request, stack, effort.configurations, options.seed), options,
      effort, monitor, on_library);
  inputs.check();
  add_files(answer.json, inputs);
  if (!options.quiet) fmt::print(table_stream(options), "{}", text);
  if (!options.html.empty())
    write_report_page(options.html, to_request(request) + ": check", answer.json, nullptr);
  write_json(answer.json, options.json);
  return answer.status;
}

}  // namespace lamella
