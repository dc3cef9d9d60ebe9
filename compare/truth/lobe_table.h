#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "compare/request/interrupt.h"
#include "compare/request/truth_request.h"
#include "compare/truth/half_vector_grid.h"
#include "volume/solver/deterministic.h"

namespace lamella {

/// Walks per outgoing node where no number is asked for: enough for a picture.
inline constexpr std::uint64_t kPreviewWalks = 10000;

/// The reflection of a stack that is symmetric about z at any pair of directions, fast enough for a
/// picture: exact single scattering plus an interpolated table of the other orders.
///
/// The integral over the hemisphere is accurate where single values are not: the table is scaled,
/// for every w_o, to the energy of the orders that it stands for, which solver and walks know
/// better than any interpolation. Under uniform light a picture thus shows the stack's directional
/// albedo, within kLobeTolerance and the energies' own errors (source() has them). For pictures:
/// the interpolation of single values has no stated bound, and deltas are left out.
class LobeTable {
 public:
  /// f [1/sr], w_i and w_o above. Where both graze, the limit of mu = HalfVectorGrid::kLeastMu.
  [[nodiscard]] Rgb operator()(Direction wi, Direction wo) const { return towards(wo)(wi); }

  /// f of one w_o as a function of w_i: the table is blended once per w_o. Must not outlive this
  /// object.
  [[nodiscard]] std::function<Rgb(Direction wi)> towards(Direction wo) const;

  /// How the table was made, for people.
  [[nodiscard]] const std::string& source() const { return source_; }

  /// By adding and doubling where the solver applies and reaches a small enough error (the
  /// estimator `auto`), else by as many next-event walks per outgoing node as are asked for. For
  /// stacks that `check_preview` lets pass.
  [[nodiscard]] static LobeTable make(const TruthRequest& request, const StopFlag* stop,
                                      const SolverReport& report = {});

 private:
  // The share of light from a node's direction that leaves on its side after two events and more,
  // by two ways, with their errors.
  struct RestEnergy {
    Rgb direct, direct_error;  // those orders' own
    Rgb total, total_error;    // of all orders: less the closed form of order 1
  };
  // Why the solver has no answer, if it has none, or one that is not near enough and no `must`.
  std::optional<std::string> solve(const Stack& stack, bool must, const StopFlag* stop,
                                   const SolverReport& report);
  void walk(const TruthRequest& request, const StopFlag* stop);
  void scale_to_energies();

  Stack stack_;
  HalfVectorGrid rest_;               // orders 2 and up
  std::vector<Rgb> scales_;           // of them at every node in mu_o and between two
  std::vector<RestEnergy> energies_;  // of the nodes in mu_o
  std::string source_;
};

/// Throws UsageError, which names `what` asked for the table, for a stack whose reflection the
/// table cannot hold: one that is not symmetric about z, is explicit geometry or has a grid.
void check_preview(const std::string& what, const Stack& stack);

}  // namespace lamella
