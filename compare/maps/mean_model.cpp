#include "compare/maps/mean_model.h"

#include <cmath>
#include <memory>
#include <utility>

#include "analytic/model/stochastic_model.h"
#include "volume/result/tally.h"

namespace lamella {
namespace {

using Texels = std::vector<std::shared_ptr<const Model>>;

// The mean of some of the texels: first, first + stride, ...
class TexelMean final : public StochasticModel {
 public:
  TexelMean(int lobes, std::shared_ptr<const Texels> texels, std::size_t first, std::size_t stride)
      : StochasticModel(lobes),
        lobe_count_(lobes),
        texels_(std::move(texels)),
        first_(first),
        stride_(stride) {}

  [[nodiscard]] Rgb eval_lobe(int lobe, Direction wi, Direction wo) const override {
    return mean([&](const Model& m) { return m.eval_lobe(lobe, wi, wo); });
  }
  [[nodiscard]] Rgb eval(Direction wi, Direction wo) const override {
    return mean([&](const Model& m) { return m.eval(wi, wo); });
  }
  void eval(std::span<const DirectionPair> pairs, std::span<Rgb> values, Isa isa) const override {
    std::vector<Rgb> part(values.size());
    std::fill(values.begin(), values.end(), Rgb(0));
    const double share = 1 / static_cast<double>(count());
    for (std::size_t k = first_; k < texels_->size(); k += stride_) {
      (*texels_)[k]->eval(pairs, part, isa);
      for (std::size_t i = 0; i < part.size(); ++i) values[i] += share * part[i];
    }
  }
  [[nodiscard]] double uncollided(Direction wi) const override {
    double sum = 0;
    for (std::size_t k = first_; k < texels_->size(); k += stride_)
      sum += (*texels_)[k]->uncollided(wi);
    return sum / static_cast<double>(count());
  }
  [[nodiscard]] Rgb specular(Direction wi) const override {
    return mean([&](const Model& m) { return m.specular(wi); });
  }
  [[nodiscard]] ValueWithError eval_with_error(Direction wi, Direction wo) const override {
    return scatter([&](const Model& m) { return m.eval(wi, wo); });
  }
  [[nodiscard]] ValueWithError eval_lobe_with_error(int lobe, Direction wi,
                                                    Direction wo) const override {
    return scatter([&](const Model& m) { return m.eval_lobe(lobe, wi, wo); });
  }
  [[nodiscard]] std::vector<std::unique_ptr<Model>> split(int parts) const override {
    std::vector<std::unique_ptr<Model>> models;
    for (std::size_t k = 0; k < static_cast<std::size_t>(parts) && k < texels_->size(); ++k)
      models.push_back(
          std::make_unique<TexelMean>(lobe_count_, texels_, k, static_cast<std::size_t>(parts)));
    return models;
  }

 private:
  [[nodiscard]] std::size_t count() const {
    return (texels_->size() - first_ + stride_ - 1) / stride_;
  }
  template <class F>
  [[nodiscard]] Rgb mean(const F& f) const {
    Rgb sum(0);
    for (std::size_t k = first_; k < texels_->size(); k += stride_) sum += f(*(*texels_)[k]);
    return 1 / static_cast<double>(count()) * sum;
  }
  // As if texels were drawn independently, which is more than the error of strata.
  template <class F>
  [[nodiscard]] ValueWithError scatter(const F& f) const {
    const Rgb value = mean(f);
    const Rgb square = mean([&](const Model& m) {
      const Rgb d = f(m) - value;
      return d * d;
    });
    const double n = static_cast<double>(count());
    Rgb error;
    if (n > 1)
      error = {std::sqrt(square.r / (n - 1)), std::sqrt(square.g / (n - 1)),
               std::sqrt(square.b / (n - 1))};
    return {value, error};
  }

  int lobe_count_;
  std::shared_ptr<const Texels> texels_;
  std::size_t first_, stride_;
};

// The same without noise.
class SolvedMean final : public Model {
 public:
  SolvedMean(int lobes, TexelMean mean) : Model(lobes), mean_(std::move(mean)) {}

  [[nodiscard]] Rgb eval_lobe(int lobe, Direction wi, Direction wo) const override {
    return mean_.eval_lobe(lobe, wi, wo);
  }
  [[nodiscard]] Rgb eval(Direction wi, Direction wo) const override { return mean_.eval(wi, wo); }
  void eval(std::span<const DirectionPair> pairs, std::span<Rgb> values, Isa isa) const override {
    mean_.eval(pairs, values, isa);
  }
  [[nodiscard]] double uncollided(Direction wi) const override { return mean_.uncollided(wi); }
  [[nodiscard]] Rgb specular(Direction wi) const override { return mean_.specular(wi); }

 private:
  TexelMean mean_;
};

// The mean of a number or colour over the texels; nothing where it is the same in all.
std::optional<ParameterValue> mean_value(const std::vector<BoundModel>& texels,
                                         const std::string& key) {
  const ParameterValue& first = texels.front().parameters.at(key);
  bool differs = false;
  Rgb sum(0);
  for (const BoundModel& texel : texels) {
    if (!texel.parameters.has(key)) return std::nullopt;
    const ParameterValue& value = texel.parameters.at(key);
    differs = differs || to_text(value) != to_text(first);
    if (const auto* number = std::get_if<double>(&value))
      sum += Rgb(*number);
    else if (const auto* color = std::get_if<Rgb>(&value))
      sum += *color;
    else
      return std::nullopt;
  }
  if (!differs) return std::nullopt;
  const Rgb mean = 1 / static_cast<double>(texels.size()) * sum;
  return std::holds_alternative<double>(first) ? ParameterValue(mean.r) : ParameterValue(mean);
}

}  // namespace

BoundModel mean_over_texels(std::vector<BoundModel> texels, bool solved) {
  BoundModel out;
  out.info = texels.front().info;
  out.parameters = texels.front().parameters;
  out.sources = texels.front().sources;
  out.object = texels.front().object;
  const auto all = texels.front().parameters.all();
  for (const auto& [key, value] : all)
    if (const auto mean = mean_value(texels, key)) {
      out.parameters.set(key, *mean);
      out.sources[key] = "mean over the map";
    }
  auto models = std::make_shared<Texels>();
  for (BoundModel& texel : texels) models->push_back(std::move(texel.model));
  const int lobes = static_cast<int>(out.info->lobes.size());
  TexelMean mean(lobes, std::move(models), 0, 1);
  if (solved)
    out.model = std::make_unique<SolvedMean>(lobes, std::move(mean));
  else
    out.model = std::make_unique<TexelMean>(std::move(mean));
  return out;
}

}  // namespace lamella
