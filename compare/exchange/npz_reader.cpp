#include "compare/exchange/npz_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "compare/exchange/tensor_container.h"
#include "compare/files/zip_entries.h"

namespace lamella {
namespace {

static_assert(std::endian::native == std::endian::little, "archives are little-endian");

constexpr std::size_t kMostAxes = 8;

// Walks through the bytes of an archive, never beyond their end.
class NpzBytes {
 public:
  NpzBytes(std::string_view bytes, const std::string& file) : bytes_(bytes), file_(file) {}

  [[noreturn]] void refuse(const std::string& found) const {
    throw FormatError(
        fmt::format("{}: found {}; allowed: an archive as lamella writes it (.npz without "
                    "compression)",
                    file_, found));
  }
  [[nodiscard]] std::string_view take(std::size_t count) {
    if (count > bytes_.size() - at_) refuse(fmt::format("the end after {} bytes", bytes_.size()));
    at_ += count;
    return bytes_.substr(at_ - count, count);
  }
  template <class T>
  [[nodiscard]] T number() {
    T value;
    std::memcpy(&value, take(sizeof(T)).data(), sizeof(T));
    return value;
  }
  [[nodiscard]] std::size_t left() const { return bytes_.size() - at_; }

 private:
  std::string_view bytes_;
  const std::string& file_;
  std::size_t at_ = 0;
};

// The text after 'KEY': in a header of NumPy, up to `end`.
std::string_view header_value(std::string_view header, std::string_view key, char end,
                              const NpzBytes& in) {
  const std::size_t at = header.find(key);
  if (at == std::string_view::npos) in.refuse(fmt::format("no {} in an array's header", key));
  std::string_view rest = header.substr(at + key.size());
  const std::size_t to = rest.find(end);
  if (to == std::string_view::npos) in.refuse("an array's header without an end");
  return rest.substr(0, to);
}

std::vector<std::size_t> shape_of(std::string_view text, const NpzBytes& in) {
  std::vector<std::size_t> shape;
  while (!text.empty()) {
    std::size_t n = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), n);
    if (error != std::errc{} || shape.size() == kMostAxes)
      in.refuse(fmt::format("an array of the shape ({})", text));
    shape.push_back(n);
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    while (!text.empty() && (text[0] == ',' || text[0] == ' ')) text.remove_prefix(1);
  }
  return shape;
}

NpzArray array_of(std::string_view bytes, const std::string& name, const std::string& file) {
  NpzBytes in(bytes, file);
  if (in.take(8) != std::string_view("\x93NUMPY\x01\x00", 8))
    in.refuse(fmt::format("the member \"{}\", which is no array of NumPy's format 1.0", name));
  const std::string_view header = in.take(in.number<std::uint16_t>());
  const std::string_view type = header_value(header, "'descr': '", '\'', in);
  if (!header_value(header, "'fortran_order': ", ',', in).starts_with("False"))
    in.refuse(fmt::format("the array \"{}\" in Fortran's order", name));
  NpzArray array;
  array.shape = shape_of(header_value(header, "'shape': (", ')', in), in);
  const bool is_text = type.starts_with("<U");
  const std::size_t width = type == "<f8" ? 8 : type == "|b1" ? 1 : is_text ? 4 : 0;
  std::size_t count = 1;
  if (is_text) {
    const std::string_view digits = type.substr(2);
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), count);
    if (error != std::errc{} || end != digits.data() + digits.size() || !array.shape.empty())
      in.refuse(fmt::format("the array \"{}\" of type {}", name, type));
  }
  if (width == 0) in.refuse(fmt::format("the array \"{}\" of type {}", name, type));
  for (const std::size_t n : array.shape) {
    if (n != 0 && count > in.left() / n) in.refuse(fmt::format("the array \"{}\" cut off", name));
    count *= n;
  }
  if (count > in.left() / width || count * width != in.left())
    in.refuse(fmt::format("the array \"{}\" with {} bytes for {} values", name, in.left(), count));
  if (width == 8) {
    array.values.resize(count);
    if (count > 0) std::memcpy(array.values.data(), in.take(8 * count).data(), 8 * count);
  } else if (width == 1) {
    for (const char c : in.take(count)) array.values.push_back(c ? 1 : 0);
  } else {
    for (std::size_t k = 0; k < count; ++k) {
      const auto letter = in.number<std::uint32_t>();
      if (letter != 0) array.text += letter < 128 ? static_cast<char>(letter) : '?';
    }
  }
  return array;
}

}  // namespace

std::map<std::string, NpzArray> read_npz(const std::string& bytes, const std::string& file) {
  constexpr std::uint32_t kMember = 0x04034b50, kDirectory = 0x02014b50;
  NpzBytes in(bytes, file);
  std::map<std::string, NpzArray> arrays;
  for (;;) {
    const auto kind = in.number<std::uint32_t>();
    if (kind == kDirectory) return arrays;
    if (kind != kMember) in.refuse("no member of an archive where one begins");
    (void)in.number<std::uint16_t>();  // version
    if (in.number<std::uint16_t>() != 0) in.refuse("a member with flags");
    if (in.number<std::uint16_t>() != 0) in.refuse("a compressed member");
    (void)in.number<std::uint32_t>();  // time and date
    const auto sum = in.number<std::uint32_t>();
    const auto size = in.number<std::uint32_t>(), whole = in.number<std::uint32_t>();
    const auto name_size = in.number<std::uint16_t>(), more = in.number<std::uint16_t>();
    std::string name(in.take(name_size));
    (void)in.take(more);
    if (size != whole) in.refuse(fmt::format("a member \"{}\" of two sizes", name));
    const std::string content(in.take(size));
    if (checksum(content) != sum) in.refuse(fmt::format("a damaged member \"{}\"", name));
    if (name.ends_with(".npy")) name.resize(name.size() - 4);
    if (!arrays.try_emplace(name, array_of(content, name, file)).second)
      in.refuse(fmt::format("the array \"{}\" twice", name));
  }
}

LobeSet lobes_of_npz(const std::map<std::string, NpzArray>& arrays, const std::string& file) {
  const auto refuse = [&](const std::string& what) {
    throw FormatError(
        fmt::format("{}: found {}; allowed: lobes as lamella writes them", file, what));
  };
  const auto at = [&](const std::string& name, std::size_t axes) -> const NpzArray& {
    const auto found = arrays.find(name);
    if (found == arrays.end()) refuse(fmt::format("no array \"{}\"", name));
    if (found->second.shape.size() != axes)
      refuse(fmt::format("an array \"{}\" of {} axes", name, found->second.shape.size()));
    return found->second;
  };
  LobeSet set;
  const NpzArray& directions = at("directions", 2);
  if (directions.shape[1] != 3 || directions.shape[0] == 0) refuse("directions of another shape");
  for (std::size_t d = 0; d < directions.shape[0]; ++d)
    set.directions.push_back(
        {directions.values[3 * d], directions.values[3 * d + 1], directions.values[3 * d + 2]});
  const NpzArray &mu = at("mu_edges", 1), &phi = at("phi_edges", 1);
  const NpzArray& folded = at("folded", 0);
  constexpr std::size_t kMostEdges = 4097;
  if (mu.values.size() < 2 || phi.values.size() < 2 || mu.values.size() > kMostEdges ||
      phi.values.size() > kMostEdges || folded.values.size() != 1)
    refuse("edges of no cells");
  set.grid.folded = folded.values[0] != 0;
  set.grid.mu_cells = static_cast<int>(mu.values.size()) - 1;
  set.grid.phi_cells = static_cast<int>(phi.values.size() - 1) * (set.grid.folded ? 2 : 1);
  const std::size_t n = set.directions.size(), rows = mu.values.size() - 1,
                    columns = phi.values.size() - 1;
  for (const auto& [name, array] : arrays) {
    const std::size_t dot = name.find('.');
    const std::string side = name.substr(0, dot);
    if (side == "attribute") set.attributes[name.substr(dot + 1)] = array.text;
    if (dot == std::string::npos || (side != "reflect" && side != "transmit")) continue;
    const bool error = name.ends_with(".se");
    const std::string lobe = name.substr(dot + 1, name.size() - dot - 1 - (error ? 3 : 0));
    const std::vector<std::size_t>& shape = array.shape;
    if (shape.size() != 4 || shape[0] != n || shape[1] != rows || shape[2] != columns ||
        (shape[3] != 1 && shape[3] != 3) ||
        (!set.lobes.empty() && set.channels != static_cast<int>(shape[3])))
      refuse(fmt::format("the lobe \"{}\" of another shape", name));
    set.channels = static_cast<int>(shape[3]);
    // [direction][cell][channel] as [direction][channel][cell].
    const std::size_t cells = rows * columns, channels = shape[3];
    std::vector<double> values(array.values.size());
    for (std::size_t d = 0; d < n; ++d)
      for (std::size_t k = 0; k < cells; ++k)
        for (std::size_t c = 0; c < channels; ++c) {
          const double value = array.values[(d * cells + k) * channels + c];
          if (!std::isfinite(value)) refuse(fmt::format("a value of \"{}\" that is none", name));
          values[(d * channels + c) * cells + k] = value;
        }
    if (!error) {
      set.lobes.push_back({side, lobe, std::move(values), {}});
      continue;
    }
    // Names are sorted: a lobe comes before its errors.
    const auto of = std::find_if(set.lobes.begin(), set.lobes.end(), [&](const LobeBlock& block) {
      return block.side == side && block.name == lobe;
    });
    if (of == set.lobes.end()) refuse(fmt::format("errors \"{}\" without a lobe", name));
    of->standard_error = std::move(values);
  }
  if (set.lobes.empty()) refuse("no lobes");
  return set;
}

}  // namespace lamella
