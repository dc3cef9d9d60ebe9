#include "compare/exchange/exported.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <array>
#include <cmath>
#include <stdexcept>

#include "compare/exchange/merl_brdf.h"
#include "compare/exchange/tensor_container.h"

namespace lamella {
namespace {

// The k-th point of a Kronecker sequence in four dimensions (Roberts 2018: powers of the root of
// x^5 = x + 1).
std::array<double, 4> spread_point(int k) {
  constexpr double kRoot = 1.1673039782614187;
  std::array<double, 4> point{};
  double step = 1;
  for (double& x : point) {
    step /= kRoot;
    x = 0.5 + k * step;
    x -= std::floor(x);
  }
  return point;
}

// Two directions above the surface, each with density cos / pi.
DirectionPair spread_pair(int k) {
  const auto [a, b, c, d] = spread_point(k);
  // mu = 0 has no value in a file.
  return {direction_from_mu_phi(std::sqrt(std::max(a, 1e-6)), 2 * kPi * b),
          direction_from_mu_phi(std::sqrt(std::max(c, 1e-6)), 2 * kPi * d)};
}

Direction turned(Direction w, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {c * w.x - s * w.y, s * w.x + c * w.y, w.z};
}

bool is_isotropic(const Model& model) {
  // Cubatures and sums round differently from one azimuth to the next.
  constexpr double kRounding = 1e-7;
  for (int k = 0; k < 16; ++k) {
    const DirectionPair pair = spread_pair(k);
    const Rgb f = model.eval(pair.wi, pair.wo);
    for (const double angle : {0.4, 1.1, 2.9}) {
      const Rgb g = model.eval(turned(pair.wi, angle), turned(pair.wo, angle));
      for (int c = 0; c < 3; ++c)
        if (std::abs(f[c] - g[c]) > kRounding * (std::abs(f[c]) + std::abs(g[c]))) return false;
    }
  }
  return true;
}

}  // namespace

ExportedBrdf exported_model(const BoundModel& model) {
  ExportedBrdf source;
  const Model* const m = model.model.get();
  source.f = [m](std::span<const DirectionPair> pairs, std::span<Rgb> values) {
    m->eval(pairs, values, Isa::scalar);
  };
  source.isotropic = is_isotropic(*m);
  source.description = "lamella " LAMELLA_VERSION ": " + to_request(model);
  if (model.info->transmits) source.left_out.emplace_back("transmission");
  const Direction wi = direction_from_degrees(30, 0);
  if (m->specular(wi).max() > 0)
    source.left_out.emplace_back("the smooth interface's mirror image");
  if (m->uncollided(wi) > 0) source.left_out.emplace_back("light that passes without scattering");
  return source;
}

std::optional<BrdfFormat> parse_brdf_format(const std::string& text) {
  if (text == "mitsuba") return BrdfFormat::mitsuba;
  if (text == "pbrt") return BrdfFormat::pbrt;
  if (text == "merl") return BrdfFormat::merl;
  return std::nullopt;
}

TensorSize tensor_size(const std::string& name) {
  if (name == "small") return {8, 32, 16};
  if (name == "medium") return {16, 64, 32};
  if (name == "large") return {32, 128, 64};
  throw std::invalid_argument(
      fmt::format("--size: found \"{}\"; allowed: small, medium, large", name));
}

std::string brdf_bytes(const ExportedBrdf& source, BrdfFormat format, const TensorSize& size) {
  if (format != BrdfFormat::merl)
    return tensor_brdf(source.f, source.isotropic,
                       format == BrdfFormat::mitsuba ? TensorColors::rgb : TensorColors::spectra,
                       size, source.description);
  if (!source.isotropic)
    throw std::invalid_argument(
        "--to: found \"merl\" for a reflection that depends on the azimuth; allowed: mitsuba, "
        "pbrt, "
        "npz, csv");
  return merl_brdf(source.f);
}

std::unique_ptr<Model> read_brdf(const std::string& bytes, const std::string& file) {
  return bytes.starts_with("tensor_file") ? read_tensor_brdf(bytes, file)
                                          : read_merl_brdf(bytes, file);
}

ModelInfo measured_info(const std::string& name) {
  ModelInfo info;
  info.name = name;
  info.doc = "a measured material";
  info.source = "file";
  info.lobes = {{"measured", "the file's values", Order::all}};
  info.reciprocal = false;
  return info;
}

double format_error(const ExportedBrdf& source, const Model& read) {
  // Points of the cells [direction][row][column][point], w_i along mu_i^2 in equal steps.
  std::vector<DirectionPair> pairs;
  for (int d = 0; d < kErrorDirections; ++d) {
    const double mu_i = std::sqrt((d + 0.5) / kErrorDirections), phi_i = 2.4 * d;
    for (int row = 0; row < kErrorRows; ++row)
      for (int column = 0; column < kErrorColumns; ++column)
        for (int point = 0; point < kErrorPoints * kErrorPoints; ++point) {
          const double mu2 = (row + (point / kErrorPoints + 0.5) / kErrorPoints) / kErrorRows;
          const double phi =
              2 * kPi * (column + (point % kErrorPoints + 0.5) / kErrorPoints) / kErrorColumns;
          pairs.push_back({direction_from_mu_phi(mu_i, phi_i),
                           direction_from_mu_phi(std::sqrt(mu2), phi_i + phi)});
        }
  }
  std::vector<Rgb> f(pairs.size()), g(pairs.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, pairs.size(), 256), [&](const auto& range) {
    const std::size_t from = range.begin(), count = range.size();
    source.f(std::span(pairs).subspan(from, count), std::span(f).subspan(from, count));
    for (std::size_t k = from; k < range.end(); ++k) g[k] = read.eval(pairs[k].wi, pairs[k].wo);
  });
  constexpr std::size_t kOfCell = kErrorPoints * kErrorPoints;
  double difference = 0, square = 0;
  for (std::size_t cell = 0; cell < pairs.size(); cell += kOfCell) {
    Rgb mean_f, mean_g;
    for (std::size_t k = cell; k < cell + kOfCell; ++k) {
      mean_f += f[k];
      mean_g += g[k];
    }
    for (int c = 0; c < 3; ++c) {
      difference += (mean_g[c] - mean_f[c]) * (mean_g[c] - mean_f[c]);
      square += mean_f[c] * mean_f[c];
    }
  }
  return square > 0 ? std::sqrt(difference / square) : 0;
}

}  // namespace lamella
