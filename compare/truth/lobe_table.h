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

/// The least roughness alpha of an interface or a conductor whose lobe is drawn: one of 0.01 is as
/// wide as a pixel of a sphere.
inline constexpr double kLeastLobe = 0.01;

/// The reflection of a stack that is symmetric about z at any pair of directions, fast enough for a
/// picture: what is closed, exactly, plus an interpolated table of the rest. Closed are order 1,
/// or, where an interface is rough, one event at it (closed_orders.h); what smooth interfaces and
/// smooth conductors mirror is a delta and stands apart (`specular`). Rough ones of alpha below
/// kLeastLobe are drawn as smooth.
///
/// The integral over the hemisphere is accurate where single values are not: the table is scaled,
/// for every w_o, to the energy of the orders that it stands for, which solver and walks know
/// better than any interpolation. Under uniform light a picture thus shows the stack's directional
/// albedo, within kLobeTolerance and the energies' own errors (source() has them). For pictures:
/// the interpolation of single values has no stated bound, and the mirror image of delta flakes is
/// left out.
class LobeTable {
 public:
  /// f [1/sr], w_i and w_o above. Where both graze, the limit of mu = HalfVectorGrid::kLeastMu.
  [[nodiscard]] Rgb operator()(Direction wi, Direction wo) const { return towards(wo)(wi); }

  /// f of one w_o as a function of w_i: the table is blended once per w_o. Must not outlive this
  /// object.
  [[nodiscard]] std::function<Rgb(Direction wi)> towards(Direction wo) const;

  /// The share of light from w_o that leaves along its mirror image as a delta, which is no part of
  /// f.
  [[nodiscard]] Rgb specular(Direction wo) const;
  [[nodiscard]] bool has_specular() const { return stack_.has_boundaries(); }

  /// How the table was made, for people.
  [[nodiscard]] const std::string& source() const { return source_; }

  /// By adding and doubling where the solver applies and reaches a small enough error (the
  /// estimator `auto`), else by as many next-event walks per outgoing node as are asked for. For
  /// stacks that `check_preview` lets pass.
  [[nodiscard]] static LobeTable make(const TruthRequest& request, const StopFlag* stop,
                                      const SolverReport& report = {});

 private:
  // What of f is known in closed form; the table has the rest.
  enum class Closed { order_one, zero, nothing };
  // The share of light from a node's direction that leaves on its side by what the table holds, by
  // two ways, with their errors.
  struct RestEnergy {
    Rgb direct, direct_error;  // those orders' own
    Rgb total, total_error;    // of all orders without deltas: less the closed form's energy
  };
  [[nodiscard]] Rgb closed(Direction wi, Direction wo) const;
  // Why the solver has no answer, if it has none, or one that is not near enough and no `must`.
  std::optional<std::string> solve(const Stack& stack, Isa isa, bool must, const StopFlag* stop,
                                   const SolverReport& report);
  void walk(const TruthRequest& request, const StopFlag* stop);
  void scale_to_energies();

  Stack stack_;
  Closed closed_ = Closed::order_one;
  HalfVectorGrid rest_;               // what is not closed
  std::vector<Rgb> scales_;           // of them at every node in mu_o and between two
  std::vector<RestEnergy> energies_;  // of the nodes in mu_o
  std::string source_;
};

/// Throws UsageError, which names `what` asked for the table, for a stack whose reflection the
/// table cannot hold: one that is not symmetric about z, is explicit geometry, has a
/// grid, or a substrate whose closed form is not reciprocal.
void check_preview(const std::string& what, const Stack& stack);

}  // namespace lamella
