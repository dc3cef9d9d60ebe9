#include "compare/judge/verdict_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compare/request/percent.h"

namespace lamella {

std::string verdict_text(const LobeComparison& lobe) {
  const double by = lobe.relative_rmse_without_noise;
  if (lobe.verdict != Verdict::differs) return to_text(lobe.verdict);
  if (std::isinf(by)) return "differs";
  if (!lobe.is_cut()) return by == 0 ? "differs" : "differs by " + percent_text(by);
  const std::string least = percent_text(lobe.relative_rmse_least);
  const std::string most = percent_text(lobe.relative_rmse_most);
  if (least == most) return "differs by " + least;
  return fmt::format("differs by {} to {}", least.substr(0, least.rfind(' ')), most);
}

std::string verdict_legend(const std::vector<const LobeComparison*>& lobes,
                           std::uint64_t max_order) {
  if (lobes.empty()) return {};
  const bool bounded =
      std::all_of(lobes.begin(), lobes.end(), [](const auto* l) { return l->bounded; });
  const char* const unknown = bounded ? "bound" : "noise";
  std::string text = fmt::format(
      "\ntruth, model: energies of the lobe; rel. RMSE: of the cells, over the root mean square of "
      "the\n  truth's; no noise: {}\n"
      "agrees: no difference beyond the {}, and the {} could hide none above {} of rel. RMSE\n"
      "differs: beyond the {}, by this rel. RMSE without noise; insufficient: neither can be "
      "said\n",
      bounded ? "the same, as a bounded truth has none" : "with the variance of the noise removed",
      unknown, unknown, percent_text(kAgreesWithin), unknown);
  if (std::any_of(lobes.begin(), lobes.end(), [](const auto* l) { return l->is_cut(); }))
    text += fmt::format(
        "missing: walks were cut after {} events; the energies of the truth are too low by this at "
        "most,\n  all lobes together, and a cell's f by this over the cell's projected solid "
        "angle. "
        "Verdicts hold\n  wherever that light belongs (--max-order, --thin-from)\n",
        max_order);
  return text;
}

}  // namespace lamella
