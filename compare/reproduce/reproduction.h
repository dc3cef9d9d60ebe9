#pragma once

#include <cstdint>
#include <cstdio>
#include <functional>
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
  /// The same of a picture by the bytes of a format.
  void write(const std::string& name, const std::function<std::string(PictureFormat)>& draw);
};

/// A published figure that one command makes again.
struct Reproduction {
  std::string name;
  std::string doc;
  std::string source;
  std::uint64_t walks;  ///< by default
  bool has_grains;      ///< from explicit geometry, which needs Embree
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
nlohmann::ordered_json reproduce_vmf_figure_9(ReproductionContext& context);
nlohmann::ordered_json reproduce_lambert_sphere_figure_13(ReproductionContext& context);
nlohmann::ordered_json reproduce_spongecake_figure_14(ReproductionContext& context);
nlohmann::ordered_json reproduce_spongecake_figure_16(ReproductionContext& context);

/// Lobes of multiple scattering: truth, network, fit.
[[nodiscard]] const std::vector<Reproduction>& spongecake_lobe_figures();

}  // namespace lamella
