#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compare/command/command.h"
#include "compare/files/exr_file.h"
#include "compare/options/progress.h"
#include "compare/report/json_report.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;

struct Summary {
  float least = 0, greatest = 0;
  double mean = 0;
};

Summary summary_of(const std::vector<float>& values) {
  Summary s{values.front(), values.front(), 0};
  for (const float v : values) {
    s.least = std::min(s.least, v);
    s.greatest = std::max(s.greatest, v);
    s.mean += static_cast<double>(v) / static_cast<double>(values.size());
  }
  return s;
}

}  // namespace

int show_command(const Options& options) {
  const ExrImage image = read_exr(options.stack);
  std::FILE* out = table_stream(options);
  const bool ours = image.attributes.contains("lamella.version");
  if (!options.quiet) {
    fmt::print(out, "{}: {} x {} pixels, {} channels{}\n", options.stack, image.width, image.height,
               image.channels.size(), ours ? "" : ", not written by lamella");
    for (const auto& [name, value] : image.attributes) {
      std::string text = value;
      while (!text.empty() && text.back() == '\n') text.pop_back();
      const std::string key = name.starts_with("lamella.") ? name.substr(8) : name;
      // A stack has lines of its own.
      for (std::size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 18)
        text.insert(at + 1, std::string(17, ' '));
      fmt::print(out, "  {:<14} {}\n", key, text);
    }
    fmt::print(out, "  {:<38} {:>13} {:>13} {:>13}\n", "channel", "least", "mean", "greatest");
  }
  Json channels = Json::array(), attributes = Json::object();
  for (const auto& [name, values] : image.channels) {
    const Summary s = summary_of(values);
    if (!options.quiet)
      fmt::print(out, "  {:<38} {:>13.6g} {:>13.6g} {:>13.6g}\n", name, s.least, s.mean,
                 s.greatest);
    channels.push_back({{"name", name},
                        {"least", json_number(s.least)},
                        {"mean", json_number(s.mean)},
                        {"greatest", json_number(s.greatest)}});
  }
  for (const auto& [name, value] : image.attributes) attributes[name] = value;
  write_json({{"format", 1},
              {"command", "show"},
              {"version", LAMELLA_VERSION},
              {"width", image.width},
              {"height", image.height},
              {"attributes", std::move(attributes)},
              {"channels", std::move(channels)}},
             options.json);
  return kDone;
}

}  // namespace lamella
