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

/// How much a reproduction spends on two cores: a second or two, to see that it runs; under a
/// minute; minutes.
enum class Quality { draft, quick, final };

[[nodiscard]] const std::vector<std::string>& quality_names();
/// Throws std::invalid_argument for a name that is none of them.
[[nodiscard]] Quality quality_from_text(const std::string& name);

/// A statement of a paper beside what was computed about it.
struct Finding {
  std::string paper;  ///< what the paper says or shows
  std::string here;   ///< what was computed
  bool agrees;        ///< whether the second bears the first out; computed
};

/// Thrown by a figure that was stopped on its way: its pictures so far are kept, its table is not.
struct FigureStopped {};

/// What a reproduction of a published figure has to work with.
struct ReproductionContext {
  std::uint64_t seed;
  const StopFlag* stop;
  std::FILE* table;    ///< where the table goes; nullptr: nowhere
  std::string folder;  ///< where the pictures go
  std::vector<PictureFormat> formats;
  std::vector<std::string> pictures = {};  ///< names of the files written
  /// Walks (or rays, or samples) that are spent in all, about.
  std::uint64_t walks;
  Quality quality = Quality::quick;
  std::vector<Finding> findings = {};

  /// One of three values, by the quality.
  template <class T>
  [[nodiscard]] T by_quality(T draft, T quick, T final) const {
    return quality == Quality::draft ? draft : quality == Quality::quick ? quick : final;
  }
  /// Throws FigureStopped once the flag is set. Any thread.
  void go_on() const {
    if (is_set(stop)) throw FigureStopped{};
  }
  /// Writes NAME.png, NAME.svg, ... and adds them to `pictures`. Throws OutputError.
  void write(const std::string& name, const Chart& chart);
  /// The same of a picture by the bytes of a format.
  void write(const std::string& name, const std::function<std::string(PictureFormat)>& draw);
  /// A line of text in the table.
  void say(const std::string& text) const;
  /// Keeps a finding and says it.
  void find(const std::string& paper, const std::string& here, bool agrees);
};

/// A published figure that one command makes again.
struct Reproduction {
  std::string name;
  std::string doc;
  std::string source;
  std::uint64_t walks;  ///< at Quality::quick; 1: the figure needs none
  bool has_grains;      ///< from explicit geometry, which needs Embree
  /// Prints the table, writes the pictures, and gives the rows of the table.
  nlohmann::ordered_json (*run)(ReproductionContext& context);

  /// Walks of a quality: a hundredth for a draft, ten times as many at last.
  [[nodiscard]] std::uint64_t walks_of(Quality quality) const;
};

}  // namespace lamella
