#include "compare/library/library_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "analytic/catalogue/model_plugin.h"
#include "compare/fit/fitted_models.h"
#include "compare/judge/comparison.h"
#include "compare/judge/missing_light.h"
#include "compare/request/errors.h"
#include "compare/request/percent.h"
#include "compare/request/split_text.h"
#include "compare/request/stack_parameters.h"
#include "phase/math/degrees.h"

namespace lamella {
namespace {

static_assert(kLibraryMaxError == kAgreesWithin);

// Whether a key that was given has the value that the stack asks for.
bool contradicts(const ModelInfo& info, const ModelRequest& request, const Parameters& of_stack) {
  const std::vector<ParameterInfo> infos = parameters_of(info, request);
  for (const auto& [key, text] : request.values) {
    const ParameterInfo* parameter = find(infos, key);
    if (!parameter || !of_stack.has(key)) continue;
    if (to_text(parse_value(*parameter, text)) != to_text(of_stack.at(key))) return true;
  }
  return false;
}

std::string joined(const std::vector<LobeInfo>& lobes) {
  std::string text;
  for (const LobeInfo& lobe : lobes) {
    const std::string order = to_text(lobe.order);
    if (text.find(order) == std::string::npos) text += (text.empty() ? "" : " ") + order;
  }
  return text;
}

// The orders that a model is judged by.
std::vector<Order> judged_orders(const ModelInfo& info) {
  std::vector<Order> orders;
  for (const LobeInfo& lobe : info.lobes) {
    if (lobe.order == Order::all || lobe.order == Order::four_plus ||
        lobe.order == Order::scattered || lobe.order == Order::multiple)
      return {Order::all};
    if (std::find(orders.begin(), orders.end(), lobe.order) == orders.end())
      orders.push_back(lobe.order);
  }
  return orders;
}

// Sums over the cells of one direction after the other.
struct Deviation {
  double squares = 0, noise = 0, truth = 0;
  double worst_z = 0;
  std::string where{};
  Direction wi{};

  [[nodiscard]] double relative() const {
    const double left = std::max(squares - noise, 0.0);
    return truth > 0 ? std::sqrt(left / truth) : left > 0 ? HUGE_VAL : 0;
  }
};

// The lobe of one direction: [channel][cell].
std::span<const double> of_direction(const std::vector<double>& values, const LobeSet& set,
                                     std::size_t d) {
  const std::size_t count = static_cast<std::size_t>(set.channels) * set.grid.cells();
  return std::span(values).subspan(d * count, count);
}

void add(Deviation& sum, const Reference& entry, const LobeBlock& lobe, std::size_t d, Order order,
         const ProjectedLobes& model) {
  const LobeSet& set = entry.set;
  const std::span<const double> truth = of_direction(lobe.value, set, d);
  const std::span<const double> error = of_direction(lobe.standard_error, set, d);
  const std::vector<double>& values = model.lobes[order];
  const std::vector<double>& open = model.errors[order];
  std::vector<double> budget(set.channels);
  for (int c = 0; c < set.channels && !entry.unresolved.empty(); ++c)
    budget[c] = entry.unresolved[d * set.channels + c] / set.grid.projected_solid_angle();
  sum.squares +=
      squared_differences(values, truth, budget).least * static_cast<double>(truth.size());
  for (std::size_t k = 0; k < truth.size(); ++k) {
    sum.truth += truth[k] * truth[k];
    if (!entry.lobe_method.is_bounded()) sum.noise += error[k] * error[k];
    const double own = (open.empty() ? 0 : open[k]) + kProjectionTolerance * std::abs(values[k]);
    const double known = std::hypot(error[k], own);
    const double z = known > 0 ? std::abs(values[k] - truth[k]) / known : 0;
    if (!(z > sum.worst_z)) continue;
    sum.worst_z = z;
    sum.wi = set.directions[d];
    const int cell = static_cast<int>(k) % set.grid.cells();
    sum.where = fmt::format("{} {}, mu_o {:.2f} to {:.2f}, phi {:.0f} to {:.0f}", lobe.side,
                            lobe.name, set.grid.edge_mu(cell / set.grid.columns() + 1),
                            set.grid.edge_mu(cell / set.grid.columns()),
                            360.0 * (cell % set.grid.columns()) / set.grid.phi_cells,
                            360.0 * (cell % set.grid.columns() + 1) / set.grid.phi_cells);
  }
}

// "NAME[,key=value...]" of each, names that are in the index.
std::vector<ModelRequest> named_entries(const std::vector<std::string>& entries,
                                        const LibraryIndex& index) {
  std::vector<std::string> names;
  for (const LibraryEntry& entry : index.entries) names.push_back(entry.name);
  std::vector<ModelRequest> named;
  for (const std::string& text : entries) {
    named.push_back(parse_model_request(text));
    check_names({named.back().name}, names, "--entry");
  }
  return named;
}

[[noreturn]] void throw_no_claim(const std::string& model) {
  throw UsageError(
      fmt::format("--library: found no entry that {} claims; allowed: --entry NAME[,key=value...] "
                  "with an entry that lamella library show lists",
                  model));
}

}  // namespace

std::vector<LibraryClaim> library_claims(const ModelRequest& request, const LibraryIndex& index,
                                         const std::vector<std::string>& entries) {
  const ModelInfo* info = find_or_load_model(request.name);
  if (!info) check_request(request);  // throws
  std::vector<LibraryClaim> claims;
  const std::vector<ModelRequest> named = named_entries(entries, index);
  for (const LibraryEntry& entry : index.entries) {
    bool by_name = false;
    for (const ModelRequest& of : named) {
      if (of.name != entry.name) continue;
      by_name = true;
      ModelRequest asked = request;
      asked.values.insert(asked.values.end(), of.values.begin(), of.values.end());
      claims.push_back({&entry, std::move(asked)});
    }
    if (by_name || !info->applies_to) continue;
    const auto of_stack = info->applies_to(stack_of_entry(entry));
    if (of_stack && !contradicts(*info, request, *of_stack)) claims.push_back({&entry, request});
  }
  if (claims.empty()) throw_no_claim(request.name);
  return claims;
}

CheckLine check_on_entry(const LibraryClaim& claim, const std::filesystem::path& folder,
                         double max_error) {
  const Stack stack = stack_of_entry(*claim.entry);
  return check_on_entry(model_for(with_fitted_lobes(claim.request, stack), stack), *claim.entry,
                        folder, max_error);
}

CheckLine check_on_entry(const BoundModel& bound, const LibraryEntry& of,
                         const std::filesystem::path& folder, double max_error) {
  const Reference entry = read_reference(of, folder);
  const std::vector<Order> orders = judged_orders(*bound.info);
  CheckLine line{of.name, fmt::format("the lobes are those of the library within {}",
                                      percent_text(max_error))};
  Deviation sum;
  for (std::size_t d = 0; d < entry.set.directions.size(); ++d)
    for (const bool reflected : {true, false}) {
      const std::string side = reflected ? "reflect" : "transmit";
      std::optional<ProjectedLobes> model;
      for (const Order order : orders) {
        const LobeBlock* lobe = entry.set.lobe(side, to_text(order));
        if (!lobe || lobe->standard_error.empty()) continue;
        const Direction wi = entry.set.directions[d];
        if (!model)
          model = project(*bound.model, *bound.info, wi, entry.set.grid, (wi.z > 0) == reflected,
                          entry.set.channels);
        add(sum, entry, *lobe, d, order, *model);
        line.cases += static_cast<std::uint64_t>(entry.set.channels) * entry.set.grid.cells();
      }
    }
  if (line.cases == 0) {
    line.reason = fmt::format("the entry has no lobe of order {}", joined(bound.info->lobes));
    return line;
  }
  const std::uint64_t cases = line.cases;
  const double error = sum.relative();
  line.offer(error, max_error, [&] {
    return CheckCase{.text = fmt::format("relative RMSE {}, allowed {}; z {:.3g} at most{}{}",
                                         percent_text(error), percent_text(max_error), sum.worst_z,
                                         sum.where.empty() ? "" : ": ", sum.where),
                     .parameters = to_request(bound),
                     .wi = sum.where.empty() ? std::optional<Direction>() : sum.wi,
                     .wo = std::nullopt};
  });
  line.cases = cases;
  return line;
}

std::vector<CheckLine> check_on_library(const ModelRequest& request, const LibraryUse& use,
                                        const RunMonitor& monitor) {
  const LibraryIndex index = read_index(use.folder);
  std::vector<CheckLine> lines;
  for (const LibraryClaim& claim : library_claims(request, index, use.entries)) {
    if (monitor.is_stopped()) break;
    lines.push_back(check_on_entry(claim, use.folder, use.max_error));
  }
  return lines;
}

std::vector<CheckLine> check_on_library(const std::string& name, const ModelOfEntry& make,
                                        const LibraryUse& use, const RunMonitor& monitor) {
  const LibraryIndex index = read_index(use.folder);
  const std::vector<ModelRequest> named = named_entries(use.entries, index);
  if (named.empty()) throw_no_claim(name);
  std::vector<CheckLine> lines;
  for (const LibraryEntry& entry : index.entries)
    for (const ModelRequest& of : named) {
      if (of.name != entry.name || monitor.is_stopped()) continue;
      lines.push_back(
          check_on_entry(make(of, stack_of_entry(entry)), entry, use.folder, use.max_error));
    }
  return lines;
}

}  // namespace lamella
