#include "compare/report/lobe_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <optional>
#include <span>
#include <utility>

#include "compare/files/exr_file.h"
#include "compare/files/output_folder.h"

namespace lamella {
namespace {

SideResult& side_of(RunResult& run, bool reflected) {
  return reflected ? run.reflected : run.transmitted;
}

std::string side_name(bool reflected) { return reflected ? "reflect" : "transmit"; }

void append(std::vector<double>& to, std::vector<double>& from) {
  to.insert(to.end(), from.begin(), from.end());
  std::vector<double>().swap(from);
}

std::string name_of_layer(const std::string& layer) {
  for (int o = 0; o < kLobeOrders; ++o)
    if (layer == lobe_name(static_cast<Order>(o))) return to_text(static_cast<Order>(o));
  return layer;
}

std::string layer_of_name(const std::string& name) {
  for (int o = 0; o < kLobeOrders; ++o)
    if (name == to_text(static_cast<Order>(o))) return lobe_name(static_cast<Order>(o));
  return name;
}

template <class Of>
void add_energy(LobeSet& set, const std::vector<RunResult>& runs, const std::string& side,
                const std::string& name, const Of& of) {
  LobeBlock block{side, name, {}, {}};
  for (const RunResult& run : runs)
    for (int c = 0; c < set.channels; ++c) {
      const Estimate e = of(run)[c];
      block.value.push_back(e.value);
      block.standard_error.push_back(e.standard_error);
    }
  set.energies.push_back(std::move(block));
}

void add_energies(LobeSet& set, const std::vector<RunResult>& runs) {
  for (const bool reflected : {true, false}) {
    const std::string side = side_name(reflected);
    const auto of = [reflected](const RunResult& run) -> const SideResult& {
      return reflected ? run.reflected : run.transmitted;
    };
    add_energy(set, runs, side, "all", [&](const RunResult& r) { return of(r).total; });
    for (int o = 0; o < kTallyOrders; ++o)
      add_energy(set, runs, side, to_text(static_cast<Order>(o)),
                 [&](const RunResult& r) { return of(r).orders[o]; });
    add_energy(set, runs, side, to_text(Order::multiple),
               [&](const RunResult& r) { return of(r).multiple; });
    add_energy(set, runs, side, "0", [&](const RunResult& r) { return of(r).zero; });
    add_energy(set, runs, side, "specular", [&](const RunResult& r) { return of(r).specular; });
  }
  add_energy(set, runs, "", "uncollided", [](const RunResult& r) { return r.uncollided; });
  add_energy(set, runs, "", "absorbed", [](const RunResult& r) { return r.absorbed; });
  add_energy(set, runs, "", "unresolved", [](const RunResult& r) { return r.unresolved; });
  add_energy(set, runs, "", "lost", [](const RunResult& r) { return r.lost; });
  add_energy(set, runs, "", "thinned", [](const RunResult& r) { return r.thinned; });
}

// Numbers between blanks, several between commas in each.
std::vector<std::vector<double>> number_lists(const std::string& text) {
  std::vector<std::vector<double>> lists;
  const char* at = text.c_str();
  while (*at) {
    char* end = nullptr;
    const double value = std::strtod(at, &end);
    if (end == at) return {};
    if (lists.empty() || *(at - 1) == ' ') lists.emplace_back();
    lists.back().push_back(value);
    at = *end ? end + 1 : end;
  }
  return lists;
}

// A channel's name as channel_name makes it.
struct Place {
  int direction = 0;
  std::string side, layer, part, letter;
};

std::optional<Place> place_of(const std::string& name) {
  std::vector<std::string> words;
  for (std::size_t from = 0; from <= name.size();) {
    const std::size_t dot = std::min(name.find('.', from), name.size());
    words.push_back(name.substr(from, dot - from));
    from = dot + 1;
  }
  if ((words.size() != 4 && words.size() != 5) || !words[0].starts_with("wi")) return std::nullopt;
  Place place;
  const std::string digits = words[0].substr(2);
  if (digits.empty() || digits.size() > 6 ||
      digits.find_first_not_of("0123456789") != std::string::npos)
    return std::nullopt;
  place.direction = std::atoi(digits.c_str());
  place.side = words[1];
  place.layer = words[2];
  if (words.size() == 5) place.part = words[3];
  place.letter = words.back();
  return place;
}

int channel_of(const std::string& letter) {
  return letter == "Y" || letter == "R" ? 0 : letter == "G" ? 1 : letter == "B" ? 2 : -1;
}

LobeBlock& block_of(std::vector<LobeBlock>& blocks, const std::string& side,
                    const std::string& name) {
  for (LobeBlock& block : blocks)
    if (block.side == side && block.name == name) return block;
  return blocks.emplace_back(LobeBlock{side, name, {}, {}});
}

}  // namespace

const LobeBlock* LobeSet::lobe(const std::string& side, const std::string& name) const {
  for (const LobeBlock& block : lobes)
    if (block.side == side && (block.name == name || layer_of_name(block.name) == name))
      return &block;
  return nullptr;
}

LobeSet take_lobes(std::vector<RunResult>& runs) {
  LobeSet set;
  set.grid = runs.front().grid;
  set.channels = runs.front().channels;
  for (const RunResult& run : runs) set.directions.push_back(run.incident);
  const std::size_t numbers = runs.size() * set.channels * set.grid.cells();
  for (const bool reflected : {true, false})
    for (int o = 0; o < kLobeOrders; ++o) {
      // Light from below may leave where light from above cannot: a side that is there for one
      // direction is there for all, as zeros.
      bool there = false;
      for (RunResult& run : runs) there = there || !side_of(run, reflected).lobes[o].value.empty();
      if (!there) continue;
      LobeBlock block{side_name(reflected), to_text(static_cast<Order>(o)), {}, {}};
      block.value.reserve(numbers);
      block.standard_error.reserve(numbers);
      for (RunResult& run : runs) {
        LobeEstimate& lobe = side_of(run, reflected).lobes[o];
        lobe.value.resize(numbers / runs.size());
        lobe.standard_error.resize(numbers / runs.size());
        append(block.value, lobe.value);
        append(block.standard_error, lobe.standard_error);
      }
      set.lobes.push_back(std::move(block));
    }
  add_energies(set, runs);
  return set;
}

void add_cell_energies(LobeSet& set) {
  const std::size_t cells = set.grid.cells();
  for (const LobeBlock& lobe : set.lobes) {
    LobeBlock energy{lobe.side, lobe.name, {}, {}};
    for (std::size_t at = 0; at < lobe.value.size(); at += cells) {
      double sum = 0;
      for (std::size_t k = 0; k < cells; ++k) sum += lobe.value[at + k];
      energy.value.push_back(sum * set.grid.projected_solid_angle());
    }
    set.energies.push_back(std::move(energy));
  }
}

ExrImage lobe_image(const LobeSet& set) {
  ExrImage image;
  image.width = set.grid.columns();
  image.height = set.grid.rows();
  image.attributes = set.attributes;
  const std::size_t cells = set.grid.cells();
  for (std::size_t d = 0; d < set.directions.size(); ++d)
    for (const LobeBlock& block : set.lobes)
      for (const bool error : {false, true}) {
        const std::vector<double>& all = error ? block.standard_error : block.value;
        if (all.empty()) continue;
        for (int c = 0; c < set.channels; ++c)
          image.channels.emplace_back(
              channel_name(static_cast<int>(d), block.side, layer_of_name(block.name),
                           error ? "se" : "", set.channels == 1 ? "Y" : std::string(1, "RGB"[c])),
              exr_values(std::span(all).subspan((d * set.channels + c) * cells, cells)));
      }
  add_plain_channels(image);
  return image;
}

LobeSet read_lobes(const std::filesystem::path& path, const std::string& part) {
  ExrImage image = read_exr(path);
  const auto refuse = [&](const std::string& found) {
    throw OutputError(
        fmt::format("{}: found {}; allowed: a file that lamella simulate or compare wrote",
                    path.string(), found));
  };
  const auto attribute = [&](const std::string& name) -> const std::string& {
    const auto it = image.attributes.find("lamella." + name);
    if (it == image.attributes.end()) refuse("no attribute lamella." + name);
    return it->second;
  };
  LobeSet set;
  for (const std::vector<double>& w : number_lists(attribute("directions"))) {
    if (w.size() != 3) refuse("lamella.directions that are no directions");
    set.directions.push_back({w[0], w[1], w[2]});
  }
  if (set.directions.empty()) refuse("lamella.directions without any");
  set.grid.folded = attribute("phi").starts_with("folded");
  set.grid.mu_cells = image.height;
  set.grid.phi_cells = image.width * (set.grid.folded ? 2 : 1);
  const bool of_comparison = image.attributes.contains("lamella.model");
  const std::string wanted = of_comparison && part.empty() ? "truth" : part;
  std::vector<std::string> parts{of_comparison ? "truth" : ""};
  if (of_comparison) parts = {"truth", "model", "difference", "z"};
  if (std::find(parts.begin(), parts.end(), wanted) == parts.end())
    throw OutputError(fmt::format("{}: part \"{}\": not there; allowed: {}", path.string(), part,
                                  of_comparison ? "truth, model, difference, z" : "none"));
  for (const auto& [name, values] : image.channels) {
    const auto place = place_of(name);
    if (place && channel_of(place->letter) > 0) set.channels = 3;
  }
  const std::size_t cells = set.grid.cells();
  const std::size_t numbers = set.directions.size() * set.channels * cells;
  for (const auto& [name, values] : image.channels) {
    const auto place = place_of(name);
    if (!place || (place->part != wanted && place->part != "se")) continue;
    const int c = channel_of(place->letter);
    if (place->direction >= static_cast<int>(set.directions.size()) || c < 0)
      refuse(fmt::format("a channel \"{}\"", name));
    LobeBlock& block = block_of(set.lobes, place->side, name_of_layer(place->layer));
    std::vector<double>& to = place->part == "se" ? block.standard_error : block.value;
    to.resize(numbers);
    const std::size_t from = (place->direction * set.channels + c) * cells;
    for (std::size_t k = 0; k < cells; ++k) to[from + k] = static_cast<double>(values[k]);
  }
  std::erase_if(set.lobes, [](const LobeBlock& block) { return block.value.empty(); });
  if (set.lobes.empty()) refuse("no lobes");
  // The file has its channels by name; here they stand as take_lobes has them.
  const auto rank = [](const LobeBlock& block) {
    int o = 0;
    while (o < kLobeOrders && block.name != to_text(static_cast<Order>(o))) ++o;
    return std::pair(block.side, o);
  };
  std::stable_sort(set.lobes.begin(), set.lobes.end(),
                   [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
  add_cell_energies(set);
  set.attributes = std::move(image.attributes);
  return set;
}

}  // namespace lamella
