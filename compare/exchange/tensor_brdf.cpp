#include "compare/exchange/tensor_brdf.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "compare/exchange/tensor_container.h"
#include "compare/exchange/tensor_warp.h"
#include "phase/math/luminance.h"

namespace lamella {
namespace {

constexpr int kAzimuths = 17;
// Share of the density of half vectors that is even: (cos + kHorizon) of the light, which goes on
// below the horizon on the scale kHorizon, so that the table's nodes lie as near on both sides.
constexpr double kEvenShare = 0.5;
constexpr double kHorizon = 0.05;
// The last node of theta: at 90 degrees f cos of some lobes is a limit of 0 / 0.
constexpr double kLastTheta = kPi / 2 * 0.995;
constexpr double kWavelengths[] = {450, 550, 650};  // nm, of blue, green, red

SquarePoint chart_of(double theta, double phi) {
  double v = (phi + kPi) / (2 * kPi);
  v -= std::floor(v);
  return {std::sqrt(std::max(2 * theta / kPi, 0.0)), v};
}

double theta_of(Direction w) {
  // Exact near the normal, where an arc cosine is not.
  return std::atan2(std::hypot(w.x, w.y), w.z);
}

Direction half_vector_at(SquarePoint p, double phi_i) {
  const double theta = kPi / 2 * p.u * p.u, phi = 2 * kPi * p.v - kPi + phi_i;
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

Direction mirrored(Direction w, Direction m) { return 2 * dot(w, m) * m - w; }

Direction camera_at(double theta, double phi) {
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

double even_density(double cosine) {
  return cosine > 0 ? cosine + kHorizon : kHorizon * std::exp(cosine / kHorizon);
}

// f cos at half vectors, the light being the camera's direction mirrored there. Below the horizon
// f at the horizon times the cosine, negative: the reader, who interpolates between nodes on both
// sides, so finds 0 where the light sets, and is not asked for values below.
std::vector<Rgb> values_at(const BsdfFunction& f, Direction camera,
                           const std::vector<Direction>& half_vectors) {
  constexpr double kLeast = 1e-6, kDeepest = -2 * kHorizon;
  std::vector<DirectionPair> pairs;
  std::vector<std::pair<std::size_t, double>> places;  // and the cosine
  std::vector<Rgb> values(half_vectors.size());
  for (std::size_t k = 0; k < half_vectors.size(); ++k) {
    Direction light = mirrored(camera, half_vectors[k]);
    if (!(dot(camera, half_vectors[k]) > 0)) continue;
    const double cosine = std::max(light.z, kDeepest);
    light.z = std::max(light.z, kLeast);
    pairs.push_back({normalized(light), camera});
    places.emplace_back(k, cosine);
  }
  std::vector<Rgb> found(pairs.size());
  if (!pairs.empty()) f(pairs, found);
  for (std::size_t k = 0; k < pairs.size(); ++k)
    values[places[k].first] = places[k].second * found[k];
  return values;
}

// The nodes of the density of half vectors on the chart, of one direction to the camera.
std::vector<double> density_nodes(const BsdfFunction& f, Direction camera, double phi_i,
                                  int nodes) {
  std::vector<Direction> half_vectors;
  for (int r = 0; r < nodes; ++r)
    for (int c = 0; c < nodes; ++c)
      half_vectors.push_back(half_vector_at({c / (nodes - 1.0), r / (nodes - 1.0)}, phi_i));
  const std::vector<Rgb> values = values_at(f, camera, half_vectors);
  // Both parts with the Jacobian of the chart and of the half vector.
  std::vector<double> even(values.size()), own(values.size());
  double even_sum = 0, own_sum = 0;
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double u = static_cast<double>(k % nodes) / (nodes - 1);
    const double cosine = dot(camera, half_vectors[k]);
    const double jacobian =
        2 * kPi * kPi * u * std::sin(kPi / 2 * u * u) * 4 * std::max(cosine, 0.0);
    even[k] = jacobian * even_density(mirrored(camera, half_vectors[k]).z);
    own[k] = jacobian * std::max(luminance(values[k]), 0.0);
    even_sum += even[k];
    own_sum += own[k];
  }
  double largest = 0;
  for (std::size_t k = 0; k < even.size(); ++k) {
    even[k] =
        kEvenShare * even[k] / even_sum + (own_sum > 0 ? (1 - kEvenShare) * own[k] / own_sum : 0);
    largest = std::max(largest, even[k]);
  }
  for (double& d : even) d = std::max(d, 1e-4 * largest);
  return even;
}

struct Slice {
  std::vector<double> density;
  std::vector<Rgb> table;
};

Slice slice_of(const BsdfFunction& f, double theta, double phi, bool isotropic,
               const TensorSize& size) {
  // An isotropic file's half vectors are relative to the camera's azimuth, which is 0 here.
  const Direction camera = camera_at(theta, phi);
  Slice slice;
  slice.density = density_nodes(f, camera, isotropic ? phi : 0, size.density);
  const BilinearWarp warp(slice.density, size.density, size.density);
  std::vector<Direction> half_vectors;
  for (int r = 0; r < size.table; ++r)
    for (int c = 0; c < size.table; ++c)
      half_vectors.push_back(half_vector_at(
          warp.sample({c / (size.table - 1.0), r / (size.table - 1.0)}), isotropic ? phi : 0));
  slice.table = values_at(f, camera, half_vectors);
  return slice;
}

TensorField bytes_field(const std::string& name, const std::string& bytes) {
  return {name, {bytes.size()}, true, {}, bytes};
}

TensorField numbers_field(const std::string& name, std::vector<std::uint64_t> shape,
                          std::vector<float> numbers = {}) {
  return {name, std::move(shape), false, std::move(numbers), {}};
}

}  // namespace

std::string tensor_brdf(const BsdfFunction& f, bool isotropic, TensorColors colors,
                        const TensorSize& size, const std::string& description) {
  std::vector<float> theta, phi;
  for (int t = 0; t < size.directions; ++t)
    theta.push_back(static_cast<float>(kLastTheta * t / (size.directions - 1)));
  for (int p = 0; p < (isotropic ? 1 : kAzimuths); ++p)
    phi.push_back(isotropic ? 0.0f : static_cast<float>(kPi * (2.0 * p / (kAzimuths - 1) - 1)));
  std::vector<Slice> slices(theta.size() * phi.size());
  tbb::parallel_for(std::size_t{0}, slices.size(), [&](std::size_t k) {
    slices[k] = slice_of(f, static_cast<double>(theta[k % theta.size()]),
                         static_cast<double>(phi[k / theta.size()]), isotropic, size);
  });
  const std::uint64_t t = theta.size(), p = phi.size(), h = size.density, n = size.table;
  TensorField vndf = numbers_field("vndf", {p, t, h, h});
  TensorField luminances = numbers_field("luminance", {p, t, n, n});
  const bool rgb = colors == TensorColors::rgb;
  TensorField tables = numbers_field(rgb ? "rgb" : "spectra", {p, t, 3, n, n});
  for (const Slice& slice : slices) {
    for (const double d : slice.density) vndf.numbers.push_back(static_cast<float>(d));
    for (const Rgb& v : slice.table)
      luminances.numbers.push_back(static_cast<float>(std::max(luminance(v), 0.0)));
    for (int c = 0; c < 3; ++c)
      for (const Rgb& v : slice.table)
        tables.numbers.push_back(static_cast<float>(v[rgb ? c : 2 - c]));
  }
  std::vector<TensorField> fields{bytes_field("description", description),
                                  bytes_field("jacobian", std::string(1, '\1')),
                                  numbers_field("theta_i", {t}, theta),
                                  numbers_field("phi_i", {p}, phi),
                                  numbers_field("ndf", {2, 2}, std::vector<float>(4, 1)),
                                  numbers_field("sigma", {2, 2}, std::vector<float>(4, 0.25f)),
                                  std::move(vndf),
                                  std::move(luminances)};
  if (!rgb) {
    std::vector<float> nm;
    for (const double w : kWavelengths) nm.push_back(static_cast<float>(w));
    fields.push_back(numbers_field("wavelengths", {3}, nm));
  }
  fields.push_back(std::move(tables));
  return tensor_file(fields);
}

namespace {

// Where x lies among ascending nodes: the node below, and the share of the one above.
std::pair<std::size_t, double> among(const std::vector<float>& nodes, double x) {
  if (nodes.size() == 1 || x <= static_cast<double>(nodes.front())) return {0, 0};
  std::size_t k = 0;
  while (k + 2 < nodes.size() && x >= static_cast<double>(nodes[k + 1])) ++k;
  const auto a = static_cast<double>(nodes[k]), b = static_cast<double>(nodes[k + 1]);
  return {k, std::clamp((x - a) / (b - a), 0.0, 1.0)};
}

class TensorBrdf : public Model {
 public:
  TensorBrdf(std::vector<TensorField> fields, const std::string& file) : Model(1), file_(file) {
    for (TensorField& f : fields) {
      if (f.name == "theta_i")
        theta_ = take(f, 1);
      else if (f.name == "phi_i")
        phi_ = take(f, 1);
      else if (f.name == "ndf")
        ndf_ = take_table(f, ndf_shape_);
      else if (f.name == "sigma")
        sigma_ = take_table(f, sigma_shape_);
      else if (f.name == "vndf")
        vndf_ = std::move(f);
      else if (f.name == "rgb")
        rgb_ = std::move(f);
      else if (f.name == "wavelengths")
        wavelengths_ = take(f, 1);
      else if (f.name == "spectra")
        spectra_ = std::move(f);
      else if (f.name == "jacobian")
        has_jacobian_ = !f.is_bytes || (!f.bytes.empty() && f.bytes[0]);
    }
    if (theta_.empty() || phi_.empty() || ndf_.empty() || sigma_.empty() || vndf_.shape.empty())
      refuse("no measured BSDF", "the fields theta_i, phi_i, ndf, sigma, vndf");
    ascending(theta_, "theta_i");
    ascending(phi_, "phi_i");
    const std::uint64_t p = phi_.size(), t = theta_.size();
    if (vndf_.is_bytes || vndf_.shape.size() != 4 || vndf_.shape[0] != p || vndf_.shape[1] != t ||
        vndf_.shape[2] < 2 || vndf_.shape[3] < 2)
      refuse("vndf of another shape", fmt::format("({}, {}, H, W), H, W >= 2", p, t));
    finite(vndf_, true);
    find_colors(p, t);
    const std::size_t nodes = vndf_.shape[2] * vndf_.shape[3];
    for (std::size_t k = 0; k < p * t; ++k) {
      const auto from = vndf_.numbers.begin() + static_cast<std::ptrdiff_t>(k * nodes);
      std::vector<double> slice(from, from + static_cast<std::ptrdiff_t>(nodes));
      if (!(*std::max_element(slice.begin(), slice.end()) > 0))
        refuse(fmt::format("a vndf of zeros alone in slice {}", k), "some density");
      warps_.emplace_back(std::move(slice), static_cast<int>(vndf_.shape[2]),
                          static_cast<int>(vndf_.shape[3]));
    }
    vndf_.numbers.clear();
  }

  [[nodiscard]] bool isotropic() const { return phi_.size() <= 2; }

  [[nodiscard]] Rgb eval_lobe(int /*lobe*/, Direction wi, Direction wo) const override {
    const Direction camera = wo, light = wi;
    if (!(camera.z > 0) || !(light.z > 0)) return {};
    const Direction sum = camera + light;
    if (!(dot(sum, sum) > 1e-12)) return {};
    const Direction m = normalized(sum);
    const double theta_i = theta_of(camera), phi_i = std::atan2(camera.y, camera.x);
    const double theta_m = theta_of(m), phi_m = std::atan2(m.y, m.x);
    const SquarePoint p = chart_of(theta_m, isotropic() ? phi_m - phi_i : phi_m);
    const auto [t, along_t] = among(theta_, theta_i);
    const auto [a, along_p] = among(phi_, reduced(phi_i));
    // The readers interpolate densities and their sums between slices, which is the warp of the
    // interpolated density: its marginal and conditional are sums of the slices'.
    std::array<std::pair<std::size_t, double>, 4> parts;
    std::size_t count = 0;
    for (const int dp : {0, 1})
      for (const int dt : {0, 1}) {
        const double weight = (dp ? along_p : 1 - along_p) * (dt ? along_t : 1 - along_t);
        if (weight > 0) parts[count++] = {(a + dp) * theta_.size() + t + dt, weight};
      }
    const SquarePoint s = inverted(std::span(parts).first(count), p);
    Rgb value;
    for (std::size_t k = 0; k < count; ++k) value += parts[k].second * table(parts[k].first, s);
    double scale = 1 / light.z;
    if (has_jacobian_) {
      const double ndf = bilinear(ndf_, ndf_shape_[0], ndf_shape_[1], p);
      const double sigma = bilinear(sigma_, sigma_shape_[0], sigma_shape_[1],
                                    chart_of(theta_i, isotropic() ? 0 : phi_i));
      scale *= sigma > 0 ? ndf / (4 * sigma) : 0;
    }
    return scale * Rgb(std::max(value.r, 0.0), std::max(value.g, 0.0), std::max(value.b, 0.0));
  }

 private:
  [[noreturn]] void refuse(const std::string& found, const std::string& allowed) const {
    throw FormatError(fmt::format("{}: found {}; allowed: {}", file_, found, allowed));
  }
  std::vector<float> take(TensorField& f, std::size_t axes) const {
    if (f.is_bytes || f.shape.size() != axes || f.numbers.empty())
      refuse(fmt::format("{} of another shape", f.name), fmt::format("{} axes", axes));
    finite(f, false);
    return std::move(f.numbers);
  }
  std::vector<float> take_table(TensorField& f, std::array<int, 2>& shape) const {
    if (f.shape.size() == 2) shape = {static_cast<int>(f.shape[0]), static_cast<int>(f.shape[1])};
    return take(f, 2);
  }
  void finite(const TensorField& f, bool not_negative) const {
    for (const float v : f.numbers)
      if (!std::isfinite(v) || (not_negative && v < 0))
        refuse(fmt::format("{} of {}", f.name, v),
               not_negative ? "finite numbers, not below 0" : "finite numbers");
  }
  void ascending(const std::vector<float>& nodes, const char* name) const {
    for (std::size_t k = 1; k < nodes.size(); ++k)
      if (!(nodes[k] > nodes[k - 1]))
        refuse(fmt::format("{} that do not ascend", name), "ascending");
  }
  // Which of the tables stand for red, green and blue.
  void find_colors(std::uint64_t p, std::uint64_t t) {
    const bool spectral = !spectra_.shape.empty() && !wavelengths_.empty();
    colors_ = spectral ? std::move(spectra_) : std::move(rgb_);
    const std::uint64_t count = spectral ? wavelengths_.size() : 3;
    const auto& shape = colors_.shape;
    if (colors_.is_bytes || shape.size() != 5 || shape[0] != p || shape[1] != t ||
        shape[2] != count || shape[3] < 2 || shape[4] < 2)
      refuse(spectral ? "spectra of another shape" : "no rgb, or one of another shape",
             fmt::format("({}, {}, {}, N, N)", p, t, count));
    finite(colors_, false);
    for (int c = 0; c < 3; ++c) {
      if (!spectral) {
        channels_[c] = {static_cast<std::size_t>(c), 0.0};
        continue;
      }
      ascending(wavelengths_, "wavelengths");
      channels_[c] = among(wavelengths_, kWavelengths[2 - c]);
    }
  }
  // The azimuth within what the nodes span: measurements of symmetric materials cover a part.
  [[nodiscard]] double reduced(double phi) const {
    const auto first = static_cast<double>(phi_.front()), last = static_cast<double>(phi_.back());
    const double span = last - first;
    if (!(span > 0) || isotropic()) return phi;
    const double turns = (phi - first) / span;
    return first + span * (turns - std::floor(turns));
  }
  [[nodiscard]] SquarePoint inverted(std::span<const std::pair<std::size_t, double>> parts,
                                     SquarePoint p) const {
    if (parts.size() == 1) return warps_[parts[0].first].invert(p);
    return BilinearWarp::invert_mixed(warps_, parts, p);
  }
  [[nodiscard]] Rgb table(std::size_t slice, SquarePoint s) const {
    const int rows = static_cast<int>(colors_.shape[3]),
              columns = static_cast<int>(colors_.shape[4]);
    const std::size_t nodes = colors_.shape[3] * colors_.shape[4], count = colors_.shape[2];
    const auto at = [&](std::size_t channel) {
      return bilinear(std::span(colors_.numbers).subspan((slice * count + channel) * nodes, nodes),
                      rows, columns, s);
    };
    Rgb value;
    for (int c = 0; c < 3; ++c) {
      const auto [k, x] = channels_[c];
      value[c] = x > 0 ? (1 - x) * at(k) + x * at(k + 1) : at(k);
    }
    return value;
  }

  std::string file_;
  std::vector<float> theta_, phi_, ndf_, sigma_, wavelengths_;
  std::array<int, 2> ndf_shape_{}, sigma_shape_{};
  TensorField vndf_, rgb_, spectra_, colors_;
  std::array<std::pair<std::size_t, double>, 3> channels_;
  std::vector<BilinearWarp> warps_;
  bool has_jacobian_ = true;
};

}  // namespace

std::unique_ptr<Model> read_tensor_brdf(const std::string& bytes, const std::string& file) {
  return std::make_unique<TensorBrdf>(read_tensor_file(bytes, file), file);
}

}  // namespace lamella
