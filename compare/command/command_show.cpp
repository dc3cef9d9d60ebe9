#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compare/command/command.h"
#include "compare/files/exr_parts.h"
#include "compare/options/progress.h"
#include "compare/report/json_report.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

// Of the finite values of a channel.
struct Summary {
  std::string name, type;
  bool known = false;  // whether its values were read
  float least = 0, greatest = 0;
  double mean = 0;
  std::size_t not_finite = 0;
};

void summarise(const std::vector<float>& values, Summary& s) {
  s.known = true;
  std::size_t count = 0;
  for (const float v : values) {
    if (!std::isfinite(v)) {
      ++s.not_finite;
      continue;
    }
    s.least = count ? std::min(s.least, v) : v;
    s.greatest = count ? std::max(s.greatest, v) : v;
    s.mean += static_cast<double>(v);
    ++count;
  }
  if (count) s.mean /= static_cast<double>(count);
}

// The channels of a part. Those that no picture of floats holds, deep or subsampled, have a name
// and a type only. As many are read at once as the bound on memory lets pass.
std::vector<Summary> summaries_of(const std::string& path, int index, const ExrPart& part) {
  std::vector<Summary> summaries;
  std::vector<std::size_t> readable;
  for (const ExrChannel& c : part.channels) {
    if (!part.is_deep() && c.every_pixel) readable.push_back(summaries.size());
    summaries.push_back({c.name, c.type});
  }
  const auto bytes = static_cast<std::int64_t>(sizeof(float)) * part.data.width() *
                     std::max<std::int64_t>(part.data.height(), 1);
  const auto at_once = static_cast<std::size_t>(std::max<std::int64_t>(kMostExrBytes / bytes, 1));
  for (std::size_t from = 0; from < readable.size(); from += at_once) {
    std::vector<std::string> names;
    for (std::size_t k = from; k < std::min(from + at_once, readable.size()); ++k)
      names.push_back(part.channels[readable[k]].name);
    const ExrImage image = read_exr_part(path, index, names);
    for (std::size_t k = 0; k < image.channels.size(); ++k)
      summarise(image.channels[k].second, summaries[readable[from + k]]);
  }
  return summaries;
}

void print_part(std::FILE* out, const std::string& title, const ExrPart& part,
                const std::vector<Summary>& summaries) {
  const bool ours = part.attributes.contains("lamella.version");
  fmt::print(out, "{}: {} x {} pixels, {} channels{}\n", title, part.data.width(),
             part.data.height(), part.channels.size(), ours ? "" : ", not written by lamella");
  if (!ours) {
    fmt::print(out, "  {:<14} {}\n", "kind", part.kind);
    fmt::print(out, "  {:<14} {}\n", "data window", part.data.text());
    fmt::print(out, "  {:<14} {}\n", "display window", part.display.text());
  }
  for (const auto& [name, value] : part.attributes) {
    std::string text = value;
    while (!text.empty() && text.back() == '\n') text.pop_back();
    const std::string key = name.starts_with("lamella.") ? name.substr(8) : name;
    // A stack has lines of its own.
    for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 18)
      text.insert(at + 1, std::string(17, ' '));
    fmt::print(out, "  {:<14} {}\n", key, text);
  }
  fmt::print(out, "  {:<38} {:>13} {:>13} {:>13}\n", "channel", "least", "mean", "greatest");
  for (const Summary& s : summaries)
    if (!s.known)
      fmt::print(out, "  {:<38} {}\n", s.name,
                 part.is_deep() ? "deep: not read" : "subsampled: not read");
    else
      fmt::print(
          out, "  {:<38} {:>13.6g} {:>13.6g} {:>13.6g}{}\n", s.name, s.least, s.mean, s.greatest,
          s.not_finite ? fmt::format("  of the finite ones; {} are not finite", s.not_finite) : "");
}

Json json_of(const ExrWindow& w) {
  return {{"left", w.left}, {"top", w.top}, {"width", w.width()}, {"height", w.height()}};
}

Json json_of(const std::vector<Summary>& summaries) {
  Json channels = Json::array();
  for (const Summary& s : summaries) {
    Json channel{{"name", s.name}, {"type", s.type}};
    if (s.known) {
      channel["least"] = json_number(s.least);
      channel["mean"] = json_number(s.mean);
      channel["greatest"] = json_number(s.greatest);
      channel["not_finite"] = s.not_finite;
    }
    channels.push_back(std::move(channel));
  }
  return channels;
}

}  // namespace

int show_command(const Options& options) {
  const std::vector<ExrPart> parts = read_exr_parts(options.stack);
  std::FILE* out = table_stream(options);
  Json list = Json::array();
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const ExrPart& part = parts[k];
    const std::vector<Summary> summaries = summaries_of(options.stack, static_cast<int>(k), part);
    if (!options.quiet)
      print_part(out,
                 parts.size() == 1 ? options.stack
                                   : fmt::format("{}, part {} of {}, \"{}\"", options.stack, k,
                                                 parts.size(), part.name),
                 part, summaries);
    list.push_back({{"name", part.name},
                    {"kind", part.kind},
                    {"data_window", json_of(part.data)},
                    {"display_window", json_of(part.display)},
                    {"attributes", Json(part.attributes)},
                    {"channels", json_of(summaries)}});
  }
  // The first part is what a reader of files of one part looks for.
  write_json({{"format", 1},
              {"command", "show"},
              {"version", LAMELLA_VERSION},
              {"width", parts[0].data.width()},
              {"height", parts[0].data.height()},
              {"attributes", list[0]["attributes"]},
              {"channels", list[0]["channels"]},
              {"parts", std::move(list)}},
             options.json);
  return kDone;
}

}  // namespace lamella
