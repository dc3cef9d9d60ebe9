#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "compare/request/interrupt.h"
#include "compare/request/truth_request.h"
#include "volume/solver/deterministic.h"

namespace lamella {

/// The reflection of a stack that is symmetric about z at any pair of directions, fast enough for a
/// picture: exact single scattering plus an interpolated table of the rest, which is smooth.
/// For pictures: the interpolation has no stated bound, and deltas are left out.
class LobeTable {
 public:
  /// f [1/sr], w_i and w_o above. Where both graze, the limit of mu = kLeastMu.
  [[nodiscard]] Rgb operator()(Direction wi, Direction wo) const;

  /// How the table was made, for people.
  [[nodiscard]] const std::string& source() const { return source_; }

  /// By adding and doubling where that applies, else by as many next-event walks per incoming node
  /// as are asked for. For stacks that `check_preview` lets pass. `stop` ends each node early.
  [[nodiscard]] static LobeTable make(const TruthRequest& request, const StopFlag* stop,
                                      const SolverReport& report = {});

  static constexpr int kMuNodes = 24, kPhiNodes = 25;
  static constexpr double kLeastMu = 0.01;
  /// Nodes lie closer towards grazing: mu = kLeastMu + (1 - kLeastMu) (k / (kMuNodes - 1))^2.
  [[nodiscard]] static double node_mu(int k);

 private:
  [[nodiscard]] Rgb& at(int i, int o, int p) {
    return values_[(static_cast<std::size_t>(i) * kMuNodes + o) * kPhiNodes + p];
  }
  [[nodiscard]] Rgb at(int i, int o, int p) const {
    return values_[(static_cast<std::size_t>(i) * kMuNodes + o) * kPhiNodes + p];
  }
  // Why the solver has no answer, if it has none, or one whose error is above `worst`.
  std::optional<std::string> solve(const Stack& stack, double worst, const StopFlag* stop,
                                   const SolverReport& report);
  void walk(const TruthRequest& request, const StopFlag* stop);

  Stack stack_;
  std::vector<Rgb> values_;  // orders 2 and up
  std::string source_;
};

/// Throws UsageError, naming `what` asked for it, for a stack whose reflection no such table holds:
/// one that is not symmetric about z, is explicit geometry or has a grid.
void check_preview(const std::string& what, const Stack& stack);

}  // namespace lamella
