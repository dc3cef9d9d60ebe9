#include "volume/voxels/voxel_message.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

namespace lamella {
namespace {

constexpr std::uint32_t kMostWarnings = 100, kLongestText = 4096;

class Writer {
 public:
  explicit Writer(const MessageSink& sink) : sink_(sink) {}

  template <class T>
  void number(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    sink_(&value, sizeof value);
  }
  void text(std::string_view text) {
    const auto length =
        static_cast<std::uint32_t>(std::min<std::size_t>(text.size(), kLongestText));
    number(length);
    sink_(text.data(), length);
  }
  template <int N>
  void field(const VoxelField<N>& field) {
    for_each_block(field.extent(), [&](VoxelIndex i) {
      const auto values = field.block(i);
      number(static_cast<std::uint8_t>(values.size() > 1));
      sink_(values.data(), values.size_bytes());
    });
  }

  template <class F>
  static void for_each_block(const VoxelExtent& extent, const F& f) {
    VoxelIndex i;
    for (i[2] = 0; i[2] < extent.voxels[2]; i[2] += kBlockVoxels)
      for (i[1] = 0; i[1] < extent.voxels[1]; i[1] += kBlockVoxels)
        for (i[0] = 0; i[0] < extent.voxels[0]; i[0] += kBlockVoxels) f(i);
  }

 private:
  const MessageSink& sink_;
};

class MessageReader {
 public:
  explicit MessageReader(std::string_view bytes) : bytes_(bytes) {}

  template <class T>
  [[nodiscard]] T number() {
    T value{};
    copy(&value, sizeof value);
    return value;
  }
  [[nodiscard]] std::string text() {
    const auto length = number<std::uint32_t>();
    if (length > kLongestText) damaged();
    std::string text(length, ' ');
    copy(text.data(), length);
    return text;
  }
  // Every component in [low, high], NaN in no range.
  template <int N>
  void field(float low, float high, VoxelField<N>& field) {
    std::vector<std::array<float, N>> values;
    Writer::for_each_block(field.extent(), [&](VoxelIndex i) {
      values.resize(number<std::uint8_t>() != 0 ? kBlockVoxels * kBlockVoxels * kBlockVoxels : 1);
      copy(values.data(), values.size() * sizeof values[0]);
      field.set_block(i, values);
    });
    // Of blocks on the edge, only what lies in the extent has a meaning.
    for_each_value(field, [&](VoxelIndex, const std::array<float, N>& value) {
      for (const float v : value)
        if (!(v >= low && v <= high)) damaged();
    });
  }
  void end() const {
    if (!bytes_.empty()) damaged();
  }
  [[noreturn]] static void damaged() {
    throw GridFileError("found voxels that its own reader has damaged; allowed: a .vdb file");
  }

 private:
  void copy(void* to, std::size_t count) {
    if (bytes_.size() < count) damaged();
    std::memcpy(to, bytes_.data(), count);
    bytes_.remove_prefix(count);
  }

  std::string_view bytes_;
};

}  // namespace

void write_message(const VdbGrids& grids, const MessageSink& sink) {
  Writer writer(sink);
  const Voxels& voxels = grids.voxels;
  writer.number(voxels.extent().voxels);
  writer.number(grids.first_voxel);
  writer.number(static_cast<std::uint8_t>(voxels.orientation.has_value()));
  writer.number(static_cast<std::uint8_t>(voxels.roughness.has_value()));
  writer.number(static_cast<std::uint8_t>(voxels.albedo.has_value()));
  writer.text(grids.extent_source);
  writer.number(static_cast<std::uint32_t>(grids.warnings.size()));
  for (const std::string& warning : grids.warnings) writer.text(warning);
  writer.field(voxels.density);
  if (voxels.orientation) writer.field(*voxels.orientation);
  if (voxels.roughness) writer.field(*voxels.roughness);
  if (voxels.albedo) writer.field(*voxels.albedo);
}

VdbGrids read_message(std::string_view bytes) {
  MessageReader reader(bytes);
  const VoxelExtent extent{reader.number<VoxelIndex>()};
  double blocks = 1;
  for (const int n : extent.voxels) {
    if (n < 1) MessageReader::damaged();
    blocks *= std::ceil(static_cast<double>(n) / kBlockVoxels);
  }
  if (blocks > static_cast<double>(kMostBlocks)) MessageReader::damaged();
  VdbGrids out{Voxels(extent)};
  out.first_voxel = reader.number<VoxelIndex>();
  if (reader.number<std::uint8_t>() != 0) out.voxels.orientation.emplace(extent);
  if (reader.number<std::uint8_t>() != 0) out.voxels.roughness.emplace(extent);
  if (reader.number<std::uint8_t>() != 0) out.voxels.albedo.emplace(extent);
  out.extent_source = reader.text();
  const auto count = reader.number<std::uint32_t>();
  if (count > kMostWarnings) MessageReader::damaged();
  for (std::uint32_t k = 0; k < count; ++k) out.warnings.push_back(reader.text());
  constexpr float kMost = std::numeric_limits<float>::max();
  reader.field(0, kMost, out.voxels.density);
  if (out.voxels.orientation) reader.field(-kMost, kMost, *out.voxels.orientation);
  if (out.voxels.roughness) reader.field(0, 1, *out.voxels.roughness);
  if (out.voxels.albedo) reader.field(0, 1, *out.voxels.albedo);
  reader.end();
  return out;
}

}  // namespace lamella
