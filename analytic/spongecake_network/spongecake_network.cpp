#include "analytic/spongecake_network/spongecake_network.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "analytic/spongecake_network/spongecake_ranges.h"

namespace lamella {
namespace {

constexpr int kSteps = 4;
constexpr int kLayerInputs = 8, kLayerOutputs = 4, kCrossInputs = 2;
// As in train.py.
constexpr double kLeastRoughness = 0.02, kMostRoughness = 0.999, kLeastF0 = 0.01,
                 kLeastShare = 0.01;
constexpr double kMostChange = 4, kConstantOffset = 4;

int inputs_of(int layers) { return kLayerInputs * layers + (layers == 2 ? kCrossInputs : 0); }
int outputs_of(int layers) { return kLayerOutputs * layers + 2; }

// CRC-32 of ISO 3309, as zlib has it.
std::uint32_t crc_of(std::string_view bytes) {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t n = 0; n < 256; ++n) {
    std::uint32_t c = n;
    for (int k = 0; k < 8; ++k) c = c & 1 ? 0xEDB88320u ^ (c >> 1) : c >> 1;
    table[n] = c;
  }
  std::uint32_t crc = ~0u;
  for (const char byte : bytes)
    crc = table[(crc ^ static_cast<unsigned char>(byte)) & 255] ^ (crc >> 8);
  return ~crc;
}

[[noreturn]] void refuse(const std::string& found) {
  throw std::invalid_argument(fmt::format(
      "weights of SpongeCake's network: found {}; allowed: a file of train.py, version 1", found));
}

// Reads no more than there is.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : bytes_(bytes) {}
  template <class T>
  T get() {
    T value;
    take(&value, sizeof(T));
    return value;
  }
  std::vector<float> floats(std::size_t count) {
    if (count > bytes_.size() / sizeof(float)) refuse("an end within the weights");
    std::vector<float> values(count);
    take(values.data(), count * sizeof(float));
    for (const float v : values)
      if (!std::isfinite(v)) refuse("a weight that is not finite");
    return values;
  }
  [[nodiscard]] bool at_end() const { return bytes_.empty(); }

 private:
  void take(void* to, std::size_t size) {
    if (size > bytes_.size()) refuse("an end within the header");
    std::memcpy(to, bytes_.data(), size);
    bytes_.remove_prefix(size);
  }
  std::string_view bytes_;
};

double scaled(double x, const double (&range)[2]) {
  return 2 * (x - range[0]) / (range[1] - range[0]) - 1;
}
double mean_of(Rgb c) { return (c.r + c.g + c.b) / 3; }
double logit(double x) { return std::log(x / (1 - x)); }
double sigmoid(double x) { return 1 / (1 + std::exp(-x)); }
double bounded(double x) { return kMostChange * std::tanh(x / kMostChange); }
double softplus(double x) { return x > 30 ? x : std::log1p(std::exp(x)); }

using Numbers =
    Eigen::Matrix<float, Eigen::Dynamic, 1, Eigen::ColMajor, SpongecakeNetwork::kHidden, 1>;

Numbers features(std::span<const NetworkLayer> layers, int c) {
  Numbers x(inputs_of(static_cast<int>(layers.size())));
  int at = 0;
  const auto put = [&](double v) { x(at++) = static_cast<float>(v); };
  for (const NetworkLayer& layer : layers) {
    const double* depth = SpongecakeRanges::kDepth;
    put(scaled(layer.roughness, SpongecakeRanges::kRoughness));
    put(2 * std::log(layer.depth / depth[0]) / std::log(depth[1] / depth[0]) - 1);
    put(layer.fiber ? 1 : -1);
    put(2 * layer.axis.z * layer.axis.z - 1);
    put(2 * layer.albedo[c] - 1);
    put(2 * layer.f0[c] - 1);
    put(2 * mean_of(layer.albedo) - 1);
    put(2 * mean_of(layer.f0) - 1);
  }
  if (layers.size() == 2) {
    const double cosine = dot(layers[0].axis, layers[1].axis);
    put(2 * cosine * cosine - 1);
    put(layers[0].axis.z * layers[1].axis.z * cosine);
  }
  return x;
}

}  // namespace

SpongecakeNetwork::SpongecakeNetwork(std::string_view weights) {
  constexpr std::string_view kMagic = "LMSC";
  if (weights.substr(0, kMagic.size()) != kMagic) refuse("another kind of file");
  if (weights.size() < kMagic.size() + 3 * sizeof(std::uint32_t))
    refuse("an end within the header");
  const std::string_view checked = weights.substr(0, weights.size() - sizeof(std::uint32_t));
  std::uint32_t crc = 0;
  std::memcpy(&crc, weights.data() + checked.size(), sizeof(crc));
  Reader in(checked.substr(kMagic.size()));
  if (const auto version = in.get<std::uint32_t>(); version != 1)
    refuse(fmt::format("version {}", version));
  const auto layers = in.get<std::uint32_t>();
  if (layers != 1 && layers != 2) refuse(fmt::format("{} layers", layers));
  layers_ = static_cast<int>(layers);
  for (int k = 0; k < kSteps; ++k) {
    const auto rows = in.get<std::uint32_t>(), columns = in.get<std::uint32_t>();
    const auto wanted_rows =
        static_cast<std::uint32_t>(k + 1 < kSteps ? kHidden : outputs_of(layers_));
    const auto wanted_columns = static_cast<std::uint32_t>(k > 0 ? kHidden : inputs_of(layers_));
    if (rows != wanted_rows || columns != wanted_columns)
      refuse(fmt::format("step {} of {} x {}", k + 1, rows, columns));
    Step step{.rows = static_cast<int>(rows),
              .columns = static_cast<int>(columns),
              .weight = {},
              .bias = {}};
    step.weight = in.floats(static_cast<std::size_t>(rows) * columns);
    step.bias = in.floats(rows);
    steps_.push_back(std::move(step));
  }
  if (!in.at_end()) refuse("more bytes than its steps take");
  if (crc != crc_of(checked)) refuse("a wrong checksum");
}

PredictedLobes SpongecakeNetwork::predict(std::span<const NetworkLayer> layers) const {
  const int count = layers_;
  if (static_cast<int>(layers.size()) != count)
    throw std::invalid_argument(
        fmt::format("SpongeCake's network of {} layers: found {}", count, layers.size()));
  std::array<Numbers, 3> out;
  for (int c = 0; c < 3; ++c) {
    Numbers x = features(layers, c);
    for (int k = 0; k < kSteps; ++k) {
      const Step& step = steps_[k];
      using Matrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
      Numbers next = Eigen::Map<const Eigen::VectorXf>(step.bias.data(), step.rows);
      next.noalias() += Eigen::Map<const Matrix>(step.weight.data(), step.rows, step.columns) * x;
      if (k + 1 < kSteps) next.array() /= 1 + (-next.array()).exp();  // SiLU
      x = next;
    }
    out[c] = x;
  }
  PredictedLobes lobes;
  for (int k = 0; k < count; ++k) {
    NetworkLayer& to = lobes.layers[k];
    to = layers[k];
    const int at = kLayerOutputs * k;
    const auto mean = [&](int number) {
      return (static_cast<double>(out[0](at + number)) + static_cast<double>(out[1](at + number)) +
              static_cast<double>(out[2](at + number))) /
             3;
    };
    const double range = kMostRoughness - kLeastRoughness;
    const double share =
        std::clamp((to.roughness - kLeastRoughness) / range, kLeastShare, 1 - kLeastShare);
    to.roughness = kLeastRoughness + range * sigmoid(logit(share) + mean(0));
    to.depth *= std::exp(bounded(mean(1)));
    for (int c = 0; c < 3; ++c) {
      const double f0 = std::clamp(to.f0[c], kLeastF0, 1 - kLeastF0);
      to.albedo[c] *= std::exp(bounded(static_cast<double>(out[c](at + 2))));
      to.f0[c] = sigmoid(logit(f0) + static_cast<double>(out[c](at + 3)));
    }
  }
  for (int c = 0; c < 3; ++c) {
    const int at = kLayerOutputs * count;
    lobes.reflect[c] = softplus(static_cast<double>(out[c](at)) - kConstantOffset);
    lobes.transmit[c] = softplus(static_cast<double>(out[c](at + 1)) - kConstantOffset);
  }
  return lobes;
}

const SpongecakeNetwork& spongecake_network(int layers) {
  static const SpongecakeNetwork one(spongecake_weights(1)), two(spongecake_weights(2));
  if (layers < 1 || layers > kNetworkLayers)
    throw std::invalid_argument(fmt::format(
        "SpongeCake's networks: found {} layers; allowed: 1 to {}", layers, kNetworkLayers));
  return layers == 1 ? one : two;
}

}  // namespace lamella
