#include "compare/exchange/merl_brdf.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

#include "compare/exchange/tensor_container.h"

namespace lamella {
namespace {

constexpr int kThetaH = 90, kThetaD = 90, kPhiD = 180;
constexpr std::size_t kBins = std::size_t{kThetaH} * kThetaD * kPhiD;
constexpr std::size_t kHeader = 3 * sizeof(std::int32_t);
constexpr std::size_t kBytes = kHeader + 3 * kBins * sizeof(double);
// f is the stored value times these.
constexpr double kScales[] = {1.0 / 1500, 1.15 / 1500, 1.66 / 1500};

std::size_t index_of(int theta_h, int theta_d, int phi_d) {
  return static_cast<std::size_t>(phi_d) + kPhiD * (theta_d + std::size_t{kThetaD} * theta_h);
}

// The pair with the half vector (theta_h, 0) and the difference vector (theta_d, phi_d).
DirectionPair pair_at(double theta_h, double theta_d, double phi_d) {
  const Direction h{std::sin(theta_h), 0, std::cos(theta_h)};
  const Direction d{std::sin(theta_d) * std::cos(phi_d), std::sin(theta_d) * std::sin(phi_d),
                    std::cos(theta_d)};
  // Turned about y, so that the normal goes to h.
  const Direction wi{h.z * d.x + h.x * d.z, d.y, h.z * d.z - h.x * d.x};
  return {normalized(wi), normalized(2 * dot(wi, h) * h - wi)};
}

class MerlBrdf : public Model {
 public:
  explicit MerlBrdf(std::vector<float> values) : Model(1), values_(std::move(values)) {}

  [[nodiscard]] Rgb eval_lobe(int /*lobe*/, Direction wi, Direction wo) const override {
    if (!(wi.z > 0) || !(wo.z > 0)) return {};
    const Direction sum = wi + wo;
    if (!(dot(sum, sum) > 1e-12)) return {};
    const Direction h = normalized(sum);
    const double theta_h = std::atan2(std::hypot(h.x, h.y), h.z);
    // w_i in the frame of the half vector.
    const double phi_h = std::atan2(h.y, h.x), c = std::cos(phi_h), s = std::sin(phi_h);
    const Direction flat{c * wi.x + s * wi.y, c * wi.y - s * wi.x, wi.z};
    const double st = std::sin(theta_h), ct = std::cos(theta_h);
    const Direction d{ct * flat.x - st * flat.z, flat.y, st * flat.x + ct * flat.z};
    const double theta_d = std::atan2(std::hypot(d.x, d.y), d.z);
    double phi_d = std::atan2(d.y, d.x);
    if (phi_d < 0) phi_d += kPi;
    return between({kThetaH * std::sqrt(2 * theta_h / kPi) - 0.5, kThetaD * 2 * theta_d / kPi - 0.5,
                    kPhiD * phi_d / kPi - 0.5});
  }

 private:
  [[nodiscard]] Rgb between(std::array<double, 3> at) const {
    const int sizes[] = {kThetaH, kThetaD, kPhiD};
    std::array<std::array<std::pair<int, double>, 2>, 3> nodes;
    for (int k = 0; k < 3; ++k) {
      // Half a turn of phi_d swaps the directions: the table is periodic there.
      const double x = k == 2 ? at[k] : std::clamp(at[k], 0.0, sizes[k] - 1.0);
      const double floor = std::floor(x);
      const int first = static_cast<int>(floor);
      const auto whole = [&](int n) {
        return k == 2 ? (n + sizes[k]) % sizes[k] : std::min(n, sizes[k] - 1);
      };
      nodes[k] = {{{whole(first), 1 - (x - floor)}, {whole(first + 1), x - floor}}};
    }
    Rgb value;
    for (int c = 0; c < 3; ++c) {
      double sum = 0, weights = 0;
      for (const auto& [h, wh] : nodes[0])
        for (const auto& [d, wd] : nodes[1])
          for (const auto& [p, wp] : nodes[2]) {
            const auto v = static_cast<double>(values_[c * kBins + index_of(h, d, p)]);
            if (v < 0) continue;
            sum += wh * wd * wp * v;
            weights += wh * wd * wp;
          }
      value[c] = weights > 0 ? sum / weights : 0;
    }
    return value;
  }

  std::vector<float> values_;  // f, [channel][bin]
};

}  // namespace

std::string merl_brdf(const BsdfFunction& f) {
  std::vector<double> values(3 * kBins, -1);
  tbb::parallel_for(0, kThetaH, [&](int h) {
    std::vector<DirectionPair> pairs;
    std::vector<std::size_t> places;
    const double root = (h + 0.5) / kThetaH;
    for (int d = 0; d < kThetaD; ++d)
      for (int p = 0; p < kPhiD; ++p) {
        const DirectionPair pair =
            pair_at(kPi / 2 * root * root, kPi / 2 * (d + 0.5) / kThetaD, kPi * (p + 0.5) / kPhiD);
        if (!(pair.wi.z > 0) || !(pair.wo.z > 0)) continue;
        pairs.push_back(pair);
        places.push_back(index_of(h, d, p));
      }
    std::vector<Rgb> found(pairs.size());
    if (!pairs.empty()) f(pairs, found);
    for (std::size_t k = 0; k < pairs.size(); ++k)
      for (int c = 0; c < 3; ++c) values[c * kBins + places[k]] = found[k][c] / kScales[c];
  });
  std::string bytes(kBytes, '\0');
  const std::int32_t sizes[] = {kThetaH, kThetaD, kPhiD};
  std::memcpy(bytes.data(), sizes, kHeader);
  std::memcpy(bytes.data() + kHeader, values.data(), 3 * kBins * sizeof(double));
  return bytes;
}

std::unique_ptr<Model> read_merl_brdf(const std::string& bytes, const std::string& file) {
  const auto refuse = [&](const std::string& found, const std::string& allowed) {
    throw FormatError(fmt::format("{}: found {}; allowed: {}", file, found, allowed));
  };
  std::int32_t sizes[3] = {};
  if (bytes.size() >= kHeader) std::memcpy(sizes, bytes.data(), kHeader);
  if (sizes[0] != kThetaH || sizes[1] != kThetaD || sizes[2] != kPhiD)
    refuse(fmt::format("a table of {} x {} x {}", sizes[0], sizes[1], sizes[2]),
           "90 x 90 x 180, a MERL file");
  if (bytes.size() != kBytes)
    refuse(fmt::format("{} bytes", bytes.size()), fmt::format("{}", kBytes));
  std::vector<float> values(3 * kBins);
  for (std::size_t k = 0; k < values.size(); ++k) {
    double stored;
    std::memcpy(&stored, bytes.data() + kHeader + k * sizeof(double), sizeof(double));
    const double f = stored * kScales[k / kBins];
    if (!(std::abs(f) < 1e30))
      refuse(fmt::format("a value of {} in bin {}", stored, k % kBins), "finite numbers");
    values[k] = static_cast<float>(f);
  }
  return std::make_unique<MerlBrdf>(std::move(values));
}

}  // namespace lamella
