#pragma once

#include <string>
#include <vector>

#include "phase/parameters/parameters.h"

namespace lamella {

/// A dimensionless number in [min, max].
[[nodiscard]] inline ParameterInfo number_parameter(std::string name, std::string doc,
                                                    std::string default_value, double min,
                                                    double max) {
  return {.name = std::move(name),
          .unit = "1",
          .doc = std::move(doc),
          .default_value = std::move(default_value),
          .min = min,
          .max = max};
}

/// A dimensionless colour, each channel in [0, max].
[[nodiscard]] inline ParameterInfo color_parameter(std::string name, std::string doc,
                                                   std::string default_value, double max = 1) {
  return {.name = std::move(name),
          .kind = ParameterKind::color,
          .unit = "1",
          .doc = std::move(doc),
          .default_value = std::move(default_value),
          .min = 0,
          .max = max};
}

/// One of some words, the first being the default.
[[nodiscard]] inline ParameterInfo choice_parameter(std::string name, std::string doc,
                                                    std::vector<std::string> words) {
  ParameterInfo info{.name = std::move(name),
                     .kind = ParameterKind::choice,
                     .unit = "1",
                     .doc = std::move(doc),
                     .default_value = words.front()};
  info.choices = std::move(words);
  return info;
}

}  // namespace lamella
