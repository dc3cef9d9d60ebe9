#include "compare/exchange/lobe_archive.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <span>
#include <utility>
#include <vector>

#include "phase/math/degrees.h"

namespace lamella {
namespace {

static_assert(std::endian::native == std::endian::little, "archives are little-endian");

void put(std::string& to, std::uint64_t value, int bytes) {
  for (int k = 0; k < bytes; ++k) to += static_cast<char>(value >> 8 * k & 255);
}

// A zip archive without compression; members of 4 GiB are refused by the caller.
class Archive {
 public:
  void add(const std::string& name, const std::string& bytes) {
    std::string common;
    put(common, 20, 2);    // version 2.0
    put(common, 0, 2);     // flags
    put(common, 0, 2);     // stored
    put(common, 0, 2);     // no time
    put(common, 0x21, 2);  // 1980-01-01
    put(common, crc32_of(bytes), 4);
    put(common, bytes.size(), 4);
    put(common, bytes.size(), 4);
    put(common, name.size(), 2);
    put(common, 0, 2);
    put(directory_, 0x02014b50, 4);
    put(directory_, 20, 2);
    directory_ += common;
    put(directory_, 0, 2);  // no comment
    put(directory_, 0, 2);  // first disk
    put(directory_, 0, 2);  // no attributes
    put(directory_, 0, 4);
    put(directory_, bytes_.size(), 4);
    directory_ += name;
    put(bytes_, 0x04034b50, 4);
    bytes_ += common + name + bytes;
    ++count_;
  }
  [[nodiscard]] std::string finish() && {
    const std::size_t at = bytes_.size();
    bytes_ += directory_;
    put(bytes_, 0x06054b50, 4);
    put(bytes_, 0, 4);
    put(bytes_, count_, 2);
    put(bytes_, count_, 2);
    put(bytes_, directory_.size(), 4);
    put(bytes_, at, 4);
    put(bytes_, 0, 2);
    return std::move(bytes_);
  }

 private:
  std::string bytes_, directory_;
  std::uint64_t count_ = 0;
};

// NumPy's format 1.0. `shape`: as Python writes a tuple.
std::string npy(const std::string& type, const std::string& shape, const std::string& data) {
  std::string header =
      fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': {}, }}", type, shape);
  header.append(63 - (10 + header.size()) % 64, ' ');
  header += '\n';
  std::string bytes("\x93NUMPY\x01\x00", 8);
  put(bytes, header.size(), 2);
  return bytes + header + data;
}

std::string raw(std::span<const double> numbers) {
  return {reinterpret_cast<const char*>(numbers.data()), numbers.size_bytes()};
}

// A text as NumPy's array of no axes, four bytes a letter; other letters than ASCII become "?".
std::string text_npy(const std::string& text) {
  std::string data;
  for (const char c : text) put(data, static_cast<unsigned char>(c) < 128 ? c : '?', 4);
  if (text.empty()) put(data, 0, 4);
  return npy(fmt::format("<U{}", std::max<std::size_t>(text.size(), 1)), "()", data);
}

// As Python writes a tuple.
std::string shape_text(const std::vector<std::size_t>& shape) {
  return fmt::format("({}{})", fmt::join(shape, ", "), shape.size() == 1 ? "," : "");
}

// [direction][channel][cell] as [direction][cell][channel].
std::vector<double> channels_last(const LobeSet& set, const std::vector<double>& values) {
  const std::size_t cells = set.grid.cells(), channels = set.channels;
  std::vector<double> sorted(values.size());
  for (std::size_t d = 0; d < set.directions.size(); ++d)
    for (std::size_t c = 0; c < channels; ++c)
      for (std::size_t k = 0; k < cells; ++k)
        sorted[(d * cells + k) * channels + c] = values[(d * channels + c) * cells + k];
  return sorted;
}

}  // namespace

std::uint32_t crc32_of(const std::string& bytes) {
  static const auto table = [] {
    std::array<std::uint32_t, 256> t{};
    for (std::uint32_t k = 0; k < 256; ++k) {
      t[k] = k;
      for (int bit = 0; bit < 8; ++bit) t[k] = t[k] & 1 ? t[k] >> 1 ^ 0xEDB88320u : t[k] >> 1;
    }
    return t;
  }();
  std::uint32_t crc = ~0u;
  for (const char c : bytes) crc = crc >> 8 ^ table[(crc ^ static_cast<unsigned char>(c)) & 255];
  return ~crc;
}

std::string lobe_npz(const LobeSet& set, const std::vector<NamedArray>& further) {
  Archive archive;
  const std::size_t n = set.directions.size();
  std::vector<double> directions, mu, phi;
  for (const Direction w : set.directions) directions.insert(directions.end(), {w.x, w.y, w.z});
  for (int k = 0; k <= set.grid.rows(); ++k) mu.push_back(set.grid.edge_mu(k));
  for (int k = 0; k <= set.grid.columns(); ++k) phi.push_back(set.grid.edge_phi(k));
  archive.add("directions.npy", npy("<f8", fmt::format("({}, 3)", n), raw(directions)));
  archive.add("mu_edges.npy", npy("<f8", fmt::format("({},)", mu.size()), raw(mu)));
  archive.add("phi_edges.npy", npy("<f8", fmt::format("({},)", phi.size()), raw(phi)));
  archive.add("folded.npy", npy("|b1", "()", std::string(1, set.grid.folded ? '\1' : '\0')));
  const std::string shape =
      fmt::format("({}, {}, {}, {})", n, set.grid.rows(), set.grid.columns(), set.channels);
  for (const LobeBlock& block : set.lobes) {
    const std::string name = block.side + "." + block.name;
    archive.add(name + ".npy", npy("<f8", shape, raw(channels_last(set, block.value))));
    if (!block.standard_error.empty())
      archive.add(name + ".se.npy",
                  npy("<f8", shape, raw(channels_last(set, block.standard_error))));
  }
  for (const NamedArray& array : further)
    archive.add(array.name + ".npy", npy("<f8", shape_text(array.shape), raw(array.values)));
  for (const auto& [key, value] : set.attributes)
    archive.add("attribute." + key + ".npy", text_npy(value));
  return std::move(archive).finish();
}

std::string lobe_csv(const LobeSet& set) {
  const bool grey = set.channels == 1;
  std::string text = "theta_i,phi_i,side,lobe,mu_from,mu_to,phi_from,phi_to,";
  text += grey ? "f,se\n" : "f_r,f_g,f_b,se_r,se_g,se_b\n";
  const auto to = std::back_inserter(text);
  const std::size_t cells = set.grid.cells();
  for (std::size_t d = 0; d < set.directions.size(); ++d)
    for (const LobeBlock& block : set.lobes)
      for (std::size_t k = 0; k < cells; ++k) {
        const int row = static_cast<int>(k) / set.grid.columns();
        const int column = static_cast<int>(k) % set.grid.columns();
        fmt::format_to(to, "{},{},{},{},{:.17g},{:.17g},{:.17g},{:.17g}",
                       theta_degrees(set.directions[d]), phi_degrees(set.directions[d]), block.side,
                       block.name, set.grid.edge_mu(row + 1), set.grid.edge_mu(row),
                       360.0 * column / set.grid.phi_cells,
                       360.0 * (column + 1) / set.grid.phi_cells);
        for (const std::vector<double>* values : {&block.value, &block.standard_error})
          for (int c = 0; c < set.channels; ++c)
            if (values->empty())
              text += ',';
            else
              fmt::format_to(to, ",{:.17g}", (*values)[(d * set.channels + c) * cells + k]);
        text += '\n';
      }
  return text;
}

}  // namespace lamella
