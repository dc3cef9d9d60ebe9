#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "analytic/model/directional_integral.h"
#include "phase/lanes/isa.h"
#include "phase/math/order.h"
#include "phase/stack/stack.h"

namespace lamella {

/// A named part of a closed form. `order` is the scattering order it stands for; Order::all if it
/// stands for none in particular.
struct LobeInfo {
  std::string name;
  std::string doc;
  Order order = Order::all;
};

struct DirectionPair {
  Direction wi, wo;
};

/// A directional albedo.
struct AlbedoEstimate {
  Rgb value;
  Rgb error;                                 ///< bound; of a stochastic model one standard error
  IntegralEnd end = IntegralEnd::tolerance;  ///< of its quadrature, where it has one
};

/// One in closed form: `error` is that of its formula, rounding unless it says otherwise.
[[nodiscard]] inline AlbedoEstimate exact_albedo(Rgb value, double error = 1e-14) {
  return {value, Rgb(error), {}};
}

/// A closed form, its parameters fixed. Values are f(w_i, w_o) [1/sr], the BSDF without the cosine:
/// reflection where mu_i mu_o > 0, transmission otherwise; mu = 0 is the limit from above.
/// Directions are unit. Implementations are immutable and may be called from any thread.
class Model {
 public:
  virtual ~Model() = default;

  /// One lobe of ModelInfo::lobes.
  [[nodiscard]] virtual Rgb eval_lobe(int lobe, Direction wi, Direction wo) const = 0;

  /// All lobes at once, in the order of ModelInfo::lobes. Override where they share work.
  virtual void eval_lobes(Direction wi, Direction wo, std::span<Rgb> values) const;

  /// The sum of all lobes. Override where the sum is cheaper than its parts.
  [[nodiscard]] virtual Rgb eval(Direction wi, Direction wo) const;

  /// values[k] = eval(pairs[k]), up to rounding. Override where a batch is cheaper than its pairs.
  /// The spans have the same length; isa is supported (scalar: double, one pair after the other).
  virtual void eval(std::span<const DirectionPair> pairs, std::span<Rgb> values, Isa isa) const;
  /// A batch on the widest lanes (isa_from_text("auto"), asked once).
  void eval(std::span<const DirectionPair> pairs, std::span<Rgb> values) const;

  /// The model's own sampler: w_i given w_o from three uniforms in (0, 1), or nothing if no light
  /// can be found that way. Default: the cosine law on the side of w_o.
  [[nodiscard]] virtual std::optional<Direction> sample(Direction wo, double u1, double u2,
                                                        double u3) const;

  /// Density [1/sr] with which sample(w_o, ...) gives w_i.
  [[nodiscard]] virtual double pdf(Direction wi, Direction wo) const;

  /// Directional albedo: the share of light from w_i that leaves anywhere, the delta transmission
  /// apart, and its error. Default: adaptive cubature of f |mu_o|, relative error 1e-9, or larger
  /// where the noise of the model's values or the limits end it before. Override where there is a
  /// closed form. w_i above the surface or below; mu = 0 is the limit from above.
  [[nodiscard]] virtual AlbedoEstimate albedo_with_error(Direction wi) const;
  /// Its value.
  [[nodiscard]] Rgb albedo(Direction wi) const { return albedo_with_error(wi).value; }

  /// The share of light from w_i that passes without scattering (a delta, no part of eval).
  [[nodiscard]] virtual double uncollided(Direction wi) const;

  /// The share of light from w_i that a smooth interface reflects (a delta, no part of eval).
  [[nodiscard]] virtual Rgb specular(Direction wi) const;

 protected:
  explicit Model(int lobes) : lobes_(lobes) {}

 private:
  int lobes_;
};

/// A quantity besides the BSDF that a paper tabulates, as a function of a pair of directions.
struct PartInfo {
  std::string name;
  std::string doc;  ///< which of the directions count, and the unit
  /// From checked, complete parameters.
  std::function<Rgb(const Parameters& parameters, Direction wi, Direction wo)> eval;
};

/// A part whose values follow channel by channel from the parameter `albedo` and the cosine of w_i:
/// f(albedo, mu_i).
template <class F>
[[nodiscard]] PartInfo part_of_albedo(std::string name, std::string doc, const F& f) {
  return {std::move(name), std::move(doc), [f](const Parameters& p, Direction wi, Direction) {
            const Rgb albedo = p.color("albedo");
            const double mu = std::max(std::abs(wi.z), kGrazingLimit);
            return Rgb(f(albedo.r, mu), f(albedo.g, mu), f(albedo.b, mu));
          }};
}

/// A closed form as `lamella models` knows it.
struct ModelInfo {
  std::string name;
  std::string doc;
  std::string source;
  std::vector<ParameterInfo> parameters;
  std::vector<LobeInfo> lobes;
  bool reciprocal = true;    ///< f(w_i, w_o) = f(w_o, w_i) for reflection is claimed
  bool transmits = false;    ///< has values where mu_i mu_o < 0
  bool needs_stack = false;  ///< is built from a stack; otherwise `make` ignores it
  /// Builds the model from checked, complete parameters; `stack` is set if needs_stack. Throws
  /// ParameterError.
  std::function<std::unique_ptr<Model>(const Parameters& parameters, const Stack* stack)> make;
  /// The parameters with which the model claims to describe the stack, or nothing if it does not
  /// apply. May be empty: never applies unasked.
  std::function<std::optional<Parameters>(const Stack& stack)> applies_to;
  std::vector<PartInfo> parts = {};  ///< beside lobes, pdf and albedo
  /// Where a choice decides which further parameters there are (the closed form below micrograins):
  /// the name of that parameter, and the further ones for one of its choices.
  std::string selector = {};
  std::function<std::vector<ParameterInfo>(const std::string& choice)> selected = {};
  std::string selected_prefix = {};  ///< what their names begin with
  /// A choice whose every value is of interest: a comparison that names no model takes them all.
  std::string alternatives = {};
};

/// The parameters there are: info.parameters, and those that `choice` of the selector adds, if the
/// model has one. An unknown choice adds none.
[[nodiscard]] std::vector<ParameterInfo> parameters_of(const ModelInfo& info,
                                                       const std::string& choice);
/// The parameters there are, for a set that may have the selector among them; else its default
/// counts.
[[nodiscard]] std::vector<ParameterInfo> parameters_of(const ModelInfo& info,
                                                       const Parameters& parameters);

/// Every closed form. A new one is a file pair and a line in models.cpp.
[[nodiscard]] const std::vector<ModelInfo>& models();

/// The entry with that name, or nullptr.
[[nodiscard]] const ModelInfo* find_model(std::string_view name);

}  // namespace lamella
