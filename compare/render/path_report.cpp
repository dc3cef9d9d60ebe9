#include "compare/render/path_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "compare/drawing/chart.h"
#include "compare/files/output_folder.h"
#include "compare/report/lobe_files.h"
#include "phase/math/luminance.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

// The mean over the samples: a pixel at the object's edge counts by what the object covers of it.
double mean_luminance(const PathPicture& picture) {
  double sum = 0, count = 0;
  for (std::size_t k = 0; k < picture.samples.size(); ++k) {
    sum += luminance(picture.sum[k]);
    count += picture.samples[k];
  }
  return count > 0 ? sum / count : 0;
}

// Standard error of mean_luminance. Single samples of a pixel have the variance that those of other
// pixels have in the mean.
double mean_error(const PathPicture& picture) {
  double sum = 0, known = 0, count = 0;
  for (std::size_t k = 0; k < picture.samples.size(); ++k) {
    const double n = picture.samples[k];
    count += n;
    if (n < 2) continue;
    known += n;
    // Channels share their paths: standard errors add up with the weights of the luminance.
    const Rgb v = picture.variance(k);
    sum += std::pow(n * luminance(Rgb(std::sqrt(v.r), std::sqrt(v.g), std::sqrt(v.b))), 2);
  }
  return known > 0 ? std::sqrt(sum * count / known) / count : 0;
}

// Whether a pixel has two samples, so that the noise is known.
bool has_noise(const PathPicture& picture) {
  return std::any_of(picture.samples.begin(), picture.samples.end(),
                     [](std::uint32_t n) { return n > 1; });
}

// A dash where single samples do not tell.
std::string number_or_dash(bool is_known, double value, const char* format) {
  return is_known ? fmt::format(fmt::runtime(format), value) : "-";
}

Json number_or_null(bool is_known, double value) { return is_known ? Json(value) : Json(); }

std::uint32_t most_samples(const PathPicture& picture) {
  return *std::max_element(picture.samples.begin(), picture.samples.end());
}

// A model that sends out more light than came in gains it anew with every reflection.
void check_picture(const NamedPicture& named) {
  double largest = 0;
  for (std::size_t k = 0; k < named.picture.samples.size(); ++k)
    largest = std::max({largest, named.picture.mean(k).max(), named.picture.variance(k).max()});
  if (largest > std::numeric_limits<float>::max())
    throw OutputError(
        fmt::format("the picture of {} has values of {:.1e}, which are no floats: the model gains "
                    "light at every reflection; allowed: a smaller --depth, or other models "
                    "(--model)",
                    named.name, largest));
}

void add_picture(ExrImage& image, const NamedPicture& named, bool plain) {
  check_picture(named);
  const PathPicture& p = named.picture;
  for (int c = 0; c < 3; ++c) {
    std::vector<double> mean, variance;
    for (std::size_t k = 0; k < p.samples.size(); ++k) {
      mean.push_back(p.mean(k)[c]);
      variance.push_back(p.variance(k)[c]);
    }
    const std::string letter(1, "RGB"[c]);
    if (plain) image.channels.emplace_back(letter, exr_values(mean));
    image.channels.emplace_back(fmt::format("{}.{}", named.name, letter), exr_values(mean));
    image.channels.emplace_back(fmt::format("{}.variance.{}", named.name, letter),
                                exr_values(variance));
  }
  const std::vector<double> samples(p.samples.begin(), p.samples.end());
  image.channels.emplace_back(named.name + ".samples.Y", exr_values(samples));
}

// Error against time: of walks the noise, of others noise and bias.
Chart error_chart(const std::vector<NamedPicture>& pictures, const PathRun& run) {
  Chart chart{.title = run.stack_name + ": speed against error",
              .subtitle = fmt::format("{}, {:g} s for each picture", run.shape, *run.equal_time),
              .x_label = "seconds, as a power of ten",
              .y_label = "relative mean square error",
              .series = {},
              .log_y = true};
  for (const NamedPicture& named : pictures) {
    const double bias = &named == &pictures.front()
                            ? 0
                            : traced_error(pictures.front().picture, named.picture).bias;
    ChartSeries series{.label = named.told(), .x = {}, .y = {}};
    for (const PathPicture::Checkpoint& at : named.picture.checkpoints) {
      series.x.push_back(std::log10(at.seconds));
      series.y.push_back(at.noise + bias);
    }
    if (!series.x.empty()) chart.series.push_back(std::move(series));
  }
  return chart;
}

}  // namespace

PreviewColumn column_of(const NamedPicture& named) {
  PreviewColumn column{
      named.name, {named.picture.width, named.picture.height, {}, {}}, named.told()};
  for (std::size_t k = 0; k < named.picture.samples.size(); ++k) {
    column.image.radiance.push_back(named.picture.mean(k));
    column.image.covered.push_back(named.picture.samples[k] > 0);
  }
  return column;
}

TracedError traced_error(const PathPicture& truth, const PathPicture& picture) {
  TracedError error;
  error.noise = relative_noise(picture, truth);
  error.difference = relative_difference(picture, truth);
  const double noise = error.noise + relative_noise(truth, truth);
  error.bias = std::max(0.0, error.difference - noise);
  const auto covered = static_cast<double>(
      std::count_if(truth.samples.begin(), truth.samples.end(), [](auto n) { return n > 0; }));
  // A difference d of noise v and bias b has the variance 2 v^2 + 4 b^2 v of its square.
  if (covered > 0)
    error.bias_error = std::sqrt((2 * noise * noise + 4 * error.bias * noise) / covered);
  if (&truth != &picture)
    error.flip = flip_error(column_of({"", truth}).image, column_of({"", picture}).image);
  return error;
}

std::string picture_table(const std::vector<NamedPicture>& pictures) {
  std::string text =
      fmt::format("  {:<26} {:>7} {:>7} {:>10} {:>8} {:>9} {:>9} {:>6} {:>8}\n", "picture",
                  "samples", "seconds", "luminance", "+-", "noise", "bias^2", "FLIP", "cut");
  for (const NamedPicture& named : pictures) {
    const TracedError error = traced_error(pictures.front().picture, named.picture);
    // A long label has a line of its own.
    const bool is_long = named.told().size() > 26;
    if (is_long) text += fmt::format("  {}\n", named.told());
    const bool is_truth = &named == &pictures.front();
    const bool known = has_noise(named.picture),
               both = known && has_noise(pictures.front().picture);
    text += fmt::format("  {:<26} {:>7} {:>7.2f} {:>10.5f} {:>8} {:>9} {:>9} {:>6} {:>8.1e}\n",
                        is_long ? "" : named.told(), most_samples(named.picture),
                        named.picture.seconds, mean_luminance(named.picture),
                        number_or_dash(known, mean_error(named.picture), "{:.1e}"),
                        number_or_dash(both, error.noise, "{:.2e}"),
                        is_truth ? "truth" : number_or_dash(both, error.bias, "{:.2e}"),
                        is_truth ? "-" : fmt::format("{:.4f}", error.flip), named.picture.cut);
  }
  return text +
         "\n  noise, bias^2: relative mean square errors over the pixels; bias^2 without the noise "
         "of both\n  FLIP: what a viewer sees who flips between both pictures, 0 to 1; noise "
         "counts\n"
         "  cut: mean weight of paths that --depth ended\n";
}

Json to_json(const std::vector<NamedPicture>& pictures, const PathRun& run) {
  Json list = Json::array();
  for (const NamedPicture& named : pictures) {
    const TracedError error = traced_error(pictures.front().picture, named.picture);
    const bool known = has_noise(named.picture),
               both = known && has_noise(pictures.front().picture);
    Json checkpoints = Json::array();
    for (const PathPicture::Checkpoint& at : named.picture.checkpoints)
      checkpoints.push_back(
          {{"seconds", at.seconds}, {"samples", at.samples}, {"noise", at.noise}});
    list.push_back({{"name", named.name},
                    {"label", named.told()},
                    {"samples", most_samples(named.picture)},
                    {"seconds", named.picture.seconds},
                    {"mean_luminance", mean_luminance(named.picture)},
                    {"standard_error", number_or_null(known, mean_error(named.picture))},
                    {"noise", number_or_null(both, error.noise)},
                    {"difference", number_or_null(both, error.difference)},
                    {"bias", number_or_null(both, error.bias)},
                    {"bias_error", number_or_null(both, error.bias_error)},
                    {"flip", error.flip},
                    {"cut", named.picture.cut},
                    {"checkpoints", std::move(checkpoints)}});
  }
  return {{"shape", run.shape}, {"depth", run.depth}, {"pictures", std::move(list)}};
}

void write_path_files(const std::string& folder, const std::vector<NamedPicture>& pictures,
                      const PathRun& run, const std::vector<PictureFormat>& formats,
                      const InputFiles& inputs) {
  ExrImage image;
  image.width = pictures.front().picture.width;
  image.height = pictures.front().picture.height;
  image.attributes = {
      {"lamella.version", LAMELLA_VERSION},
      {"lamella.command", "preview"},
      {"lamella.stack", run.stack},
      {"lamella.stack_name", run.stack_name},
      {"lamella.shape", run.shape},
      {"lamella.depth", fmt::format("{}", run.depth)},
      {"lamella.conventions",
       "radiance: mean over the samples of a pixel that met the object, 0 without any; variance: "
       "of that mean; samples: how many; plain R, G, B: the truth by walks; the lamp gives a "
       "perpendicular surface the irradiance pi"}};
  for (std::size_t k = 0; k < pictures.size(); ++k) add_picture(image, pictures[k], k == 0);
  record_files(image, inputs, folder);
  write_exr(folder + "/picture.exr", image);
  std::vector<PreviewColumn> columns;
  for (const NamedPicture& named : pictures) columns.push_back(column_of(named));
  write_pictures(folder + "/picture", formats, [&](PictureFormat format) {
    return draw_preview(run.stack_name + ": " + run.shape, columns, format);
  });
  if (!run.equal_time) return;
  const Chart chart = error_chart(pictures, run);
  if (!chart.series.empty())
    write_pictures(folder + "/error", formats,
                   [&](PictureFormat format) { return draw_chart(chart, format); });
}

}  // namespace lamella
