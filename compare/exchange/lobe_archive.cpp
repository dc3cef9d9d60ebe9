#include "compare/exchange/lobe_archive.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <iterator>
#include <span>
#include <utility>
#include <vector>

#include "compare/files/zip_entries.h"
#include "phase/math/degrees.h"

namespace lamella {
namespace {

class Archive {
 public:
  void add(const std::string& name, const std::string& bytes) {
    bytes_ += zip_.begin(name, checksum(bytes), bytes.size());
    bytes_ += bytes;
  }
  [[nodiscard]] std::string finish() && { return std::move(bytes_) + zip_.end(); }

 private:
  std::string bytes_;
  ZipEntries zip_;
};

std::string npy(const std::string& type, const std::string& shape, const std::string& data) {
  return npy_header(type, shape) + data;
}

std::string raw(std::span<const double> numbers) {
  return {reinterpret_cast<const char*>(numbers.data()), numbers.size_bytes()};
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

std::string lobe_npz(const LobeSet& set, const std::vector<NamedArray>& further, NpzLobes form) {
  Archive archive;
  const bool compact = form == NpzLobes::compact;
  const auto numbers = [&](const std::string& shape, const std::vector<double>& values) {
    if (!compact) return npy("<f8", shape, raw(channels_last(set, values)));
    const std::vector<double> sorted = channels_last(set, values);
    const std::vector<float> floats(sorted.begin(), sorted.end());
    return npy("<f4", shape,
               {reinterpret_cast<const char*>(floats.data()), floats.size() * sizeof(float)});
  };
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
    archive.add(name + ".npy", numbers(shape, block.value));
    if (!block.standard_error.empty() && (!compact || block.name == "all"))
      archive.add(name + ".se.npy", numbers(shape, block.standard_error));
  }
  for (const NamedArray& array : further)
    archive.add(array.name + ".npy", npy("<f8", shape_text(array.shape), raw(array.values)));
  for (const auto& [key, value] : set.attributes)
    archive.add("attribute." + key + ".npy", npy_text(value));
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
