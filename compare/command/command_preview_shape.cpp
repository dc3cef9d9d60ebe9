#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "compare/command/command.h"
#include "compare/command/lamp_option.h"
#include "compare/command/mapped_table.h"
#include "compare/command/picture_options.h"
#include "compare/files/folder_lock.h"
#include "compare/files/output_folder.h"
#include "compare/fit/fitted_models.h"
#include "compare/maps/surface_stack.h"
#include "compare/options/progress.h"
#include "compare/render/path_report.h"
#include "compare/report/json_report.h"
#include "compare/report/wrapped_text.h"
#include "compare/request/errors.h"
#include "compare/request/interrupt.h"
#include "compare/request/model_request.h"
#include "compare/request/substrate_model.h"
#include "compare/truth/lobe_table.h"
#include "phase/stack/builtin_stacks.h"
#include "phase/stack/stack_file.h"

namespace lamella {
namespace {

// --light: the lamp by its angles from the viewer, as in pictures without --shape; nothing: none.
std::optional<Direction> lamp_of(const Options& options) {
  if (options.light == "none") return std::nullopt;
  const auto [theta, phi] = lamp_angles(options.light, ", or none");
  const double t = theta * kPi / 180, p = phi * kPi / 180;
  return Direction{std::sin(t) * std::cos(p), std::sin(t) * std::sin(p), std::cos(t)};
}

LightDome dome_of(const Options& options) {
  const std::optional<Direction> lamp = lamp_of(options);
  if (options.environment == "uniform") return {SkyKind::uniform, lamp};
  if (options.environment == "none") return {SkyKind::none, lamp};
  if (options.environment == "clear_sky") return {SkyKind::clear, lamp};
  if (options.environment == "overcast_sky") return {SkyKind::overcast, lamp};
  return {options.environment, lamp};
}

PathSettings settings_of(const Options& options) {
  PathSettings settings;
  settings.columns = options.size;
  settings.depth = options.depth;
  settings.seed = options.seed;
  settings.seconds = options.equal_time ? options.equal_time : options.seconds;
  // Without a number of samples the clock alone ends a picture.
  constexpr int kEndless = 1000000;
  settings.samples = settings.seconds && !options.samples_given ? kEndless : options.samples;
  return settings;
}

}  // namespace

int preview_shape_command(const Options& options, const std::vector<std::string>& pictures) {
  const SurfaceStack surface(
      load_mapped_stack(options.stack.empty() ? std::string(kDefaultStack) : options.stack));
  const bool mapped = surface.has_maps() && options.at.empty();
  const auto shown = [&](Stack one) {
    return options.white ? with_surface_model(whitened(std::move(one))) : one;
  };
  const Stack stack = shown(mapped ? surface.at(0.5, 0.5) : stack_of(options));
  TruthRequest request = truth_request(options, stack);
  const std::vector<PictureFormat> formats = picture_formats_of(pictures);
  const LightDome light = dome_of(options);
  const ViewedObject object(options.shape);
  const std::unique_ptr<SurfaceScatter> truth =
      mapped ? walked_surface({surface.columns(), surface.rows(),
                               [&](double u, double v) { return shown(surface.at(u, v)); }},
                              request.limits)
             : walked_surface({1, 1, [&](double, double) { return stack; }}, request.limits);
  std::vector<std::filesystem::path> read = objects_among(model_requests(options));
  if (mapped)
    for (const auto& file : surface.files()) read.push_back(file);
  for (const std::string& file : {options.environment, options.shape})
    if (std::filesystem::is_regular_file(file)) read.emplace_back(file);
  const InputFiles inputs(stack, read);
  // Of a stack with maps: those of its middle, for the names; every place has its own.
  std::vector<PlacedRequest> placed;
  std::vector<BoundModel> models;
  if (mapped)
    for (const ModelRequest& one : requests_for(model_requests(options), stack)) {
      placed.push_back(placed_request(one, stack));
      models.push_back(model_at(placed.back(), stack));
    }
  else
    models = fitted_models_for(model_requests(options), stack);
  const std::string folder = options.output.empty() ? stack.name + "-preview" : options.output;
  make_output_folder(folder);
  const FolderLock lock(folder);
  const RunMonitor monitor = terminal_monitor(options);

  std::optional<LobeTable> table;
  std::optional<MapTable> mapped_table;
  if (options.table) {
    check_preview("preview --table", stack);
    if (truth->transmits())
      throw UsageError(fmt::format(
          "--table: found {}, through which light passes, while the table has reflection alone; "
          "allowed: a stack that is opaque below",
          stack.name));
    if (mapped) {
      mapped_table = map_table(surface, request, shown, monitor);
    } else {
      table = LobeTable::make(request, monitor.stop, monitor.solver);
      if (monitor.finished) monitor.finished();
    }
  }
  const PathSettings settings = settings_of(options);
  std::vector<NamedPicture> found;
  const PathRun run{stack.name,
                    mapped ? "with maps; this is the middle:\n" + to_toml(stack) : to_toml(stack),
                    options.shape, options.depth, options.equal_time};
  // What is there is written now and then, at doubling times; not where time is measured.
  constexpr double kFirstWrite = 5;
  const auto add = [&](const std::string& name, const std::string& label,
                       const SurfaceScatter& scatter) {
    if (!found.empty() && user_interrupt) return;
    double next_write = kFirstWrite;
    const PathWatch watch = [&](const PathPicture& so_far, int samples) {
      const auto pixels = static_cast<std::uint64_t>(so_far.samples.size());
      if (monitor.progress)
        monitor.progress(label,
                         {static_cast<std::uint64_t>(samples) * pixels,
                          static_cast<std::uint64_t>(settings.samples) * pixels, so_far.seconds});
      if (options.equal_time || so_far.seconds < next_write) return;
      while (next_write <= so_far.seconds) next_write *= 2;
      std::vector<NamedPicture> now = found;
      now.push_back({name, so_far, label});
      write_path_files(folder, now, run, formats, inputs);
    };
    found.push_back(
        {name, trace_picture(object, scatter, light, settings, &user_interrupt, watch), label});
    if (monitor.finished) monitor.finished();
  };
  add("truth", "truth", *truth);
  const std::vector<std::string> names = distinct_names(models), labels = distinct_labels(models);
  for (std::size_t k = 0; k < models.size(); ++k) {
    // What lies on a ground lets no light pass, whatever the form could.
    const bool transmits = models[k].info->transmits && stack.is_open_below();
    if (mapped)
      add(names[k], labels[k],
          *closed_surface({surface.columns(), surface.rows(),
                           [&, k](double u, double v) {
                             return std::move(model_at(placed[k], shown(surface.at(u, v))).model);
                           }},
                          transmits));
    else
      add(names[k], labels[k], *closed_surface(*models[k].model, transmits));
  }
  if (table)
    add("table", "table",
        *tabulated_surface([&](Direction wo) { return table->towards(wo); },
                           table->has_specular() ? std::function<Rgb(Direction)>([&](Direction wo) {
                             return table->specular(wo);
                           })
                                                 : std::function<Rgb(Direction)>()));
  if (mapped_table) add("table", "table", *mapped_table_surface(surface, *mapped_table, shown));
  inputs.check();
  write_path_files(folder, found, run, formats, inputs);
  nlohmann::ordered_json answer = json_header("preview", request);
  answer["interrupted"] = user_interrupt.load();
  answer["traced"] = to_json(found, run);
  add_files(answer, inputs);
  if (!options.quiet) {
    std::FILE* out = table_stream(options);
    fmt::print(out, "{}: {}, paths of up to {} surface{}{}\n{}", stack.name, options.shape,
               options.depth, options.depth == 1 ? "" : "s", mapped ? ", with maps" : "",
               picture_table(found));
    if (mapped_table) fmt::print(out, "{}", wrapped("table: ", mapped_table->source(), 2));
    fmt::print(out, "\nwrote {}/: picture.exr{}\n{}", folder,
               formats.empty() ? "" : fmt::format(" and pictures ({})", endings_text(formats)),
               absent_pictures_text());
  }
  write_json(answer, options.json);
  return kDone;
}

}  // namespace lamella
