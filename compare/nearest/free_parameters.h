#pragma once

#include <span>
#include <string>
#include <vector>

#include "compare/request/model_request.h"

namespace lamella {

/// One number of a model that a fit may change, scaled to [0, 1] over the range that its parameter
/// allows: linear, or, where that spans more than three powers of ten above 0, logarithmic.
struct FreeNumber {
  std::string key;
  int channel = -1;  ///< of a colour; -1: a number, or a colour that is kept grey
  bool is_color = false;
  double low = 0, high = 1;
  bool is_logarithmic = false;
  double standard = 0;  ///< the value that a search begins with, scaled

  [[nodiscard]] double value(double scaled) const;
  [[nodiscard]] double scaled(double value) const;
  /// d value / d scaled.
  [[nodiscard]] double slope(double scaled) const;
  /// The key, with the channel where it has one: "albedo.r".
  [[nodiscard]] std::string name() const;
};

/// A closed form of which some numbers are free.
struct ParametricModel {
  const ModelInfo* info = nullptr;
  ModelRequest request;  ///< with the keys that are fixed
  Parameters fixed;      ///< all parameters, the free ones at their defaults
  std::vector<FreeNumber> free;

  [[nodiscard]] Parameters parameters(std::span<const double> scaled) const;
  /// Throws ParameterError where the model refuses the values together.
  [[nodiscard]] std::unique_ptr<Model> make(std::span<const double> scaled) const;
};

/// The model of a request, in which all numbers and colours are free that the request does not give
/// and whose range is finite; key=free frees one that is otherwise kept at its default: indices
/// (`ior`), those along y (`roughness_y`), and numbers that say how a model is computed (walks,
/// seed, terms). Colours
/// have one number per channel of the target. `info`: of the request's model. Throws UsageError.
[[nodiscard]] ParametricModel parametric_model(const ModelInfo& info, const ModelRequest& request,
                                               int channels);

/// Whether a closed form has a coat whose albedos are tabulated when it is made.
[[nodiscard]] bool has_coat_tables(const std::string& name);

/// Models from texts as --model has them: "NAME[,key=value...]"; a name begins the next model, so
/// that "oren_nayar,eon,roughness=0.5" are two; "all": every built-in closed form that needs no
/// stack and no random numbers. Throws UsageError.
[[nodiscard]] std::vector<ModelRequest> models_to_fit(const std::vector<std::string>& texts);

}  // namespace lamella
