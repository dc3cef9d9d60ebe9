#pragma once

#include <cstdint>
#include <cstdio>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "compare/drawing/chart.h"
#include "compare/request/interrupt.h"

namespace lamella {

/// What a reproduction of a published figure has to work with.
struct ReproductionContext {
  std::uint64_t seed;
  const StopFlag* stop;
  std::FILE* table;    ///< where the table goes; nullptr: nowhere
  std::string folder;  ///< where the pictures go
  std::vector<PictureFormat> formats;
  std::vector<std::string> pictures = {};  ///< names of the files written
  /// Walks (or rays) that are spent in all, about.
  std::uint64_t walks;

  /// Writes NAME.png, NAME.svg, ... and adds them to `pictures`. Throws OutputError.
  void write(const std::string& name, const Chart& chart);
};

/// A published figure that one command makes again from explicit geometry.
struct Reproduction {
  std::string name;
  std::string doc;
  std::string source;
  std::uint64_t walks;  ///< by default
  /// Prints the table, writes the pictures, and gives the rows of the table.
  nlohmann::ordered_json (*run)(ReproductionContext& context);
};

[[nodiscard]] const std::vector<Reproduction>& reproductions();

// One per figure; sources beside their list.
nlohmann::ordered_json reproduce_vmf_figure_5(ReproductionContext& context);
nlohmann::ordered_json reproduce_vmf_figure_6(ReproductionContext& context);
nlohmann::ordered_json reproduce_lambert_sphere_dilute(ReproductionContext& context);
nlohmann::ordered_json reproduce_micrograin_figure_4(ReproductionContext& context);
nlohmann::ordered_json reproduce_micrograin_figure_5(ReproductionContext& context);
nlohmann::ordered_json reproduce_micrograin_figure_9(ReproductionContext& context);

}  // namespace lamella
