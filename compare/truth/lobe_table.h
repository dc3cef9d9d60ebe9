#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "compare/request/interrupt.h"
#include "compare/request/truth_request.h"
#include "compare/truth/half_vector_grid.h"
#include "volume/solver/deterministic.h"

namespace lamella {

/// Vertical planes that mirror a stack onto itself: one with an azimuth, and the one across it.
struct SectorSymmetry {
  double azimuth = 0;                  ///< [radians]; of the plane, or where sectors begin
  bool along = false, across = false;  ///< across: only where `along` is

  /// Of `count` sectors from `azimuth` on, the one below k whose mirror image k is; k: none.
  struct Image {
    int sector;
    bool turned_over;  ///< mirrored once, not twice: left is right
  };
  [[nodiscard]] Image image_of(int k, int count) const;
};

/// Of layers whose projected areas tell all of their orientation, as those of two-sided flakes do.
[[nodiscard]] SectorSymmetry sector_symmetry(const Stack& stack);

/// Walks per outgoing node where no number is asked for: enough for a picture.
inline constexpr std::uint64_t kPreviewWalks = 10000;

/// The least roughness alpha of an interface or a conductor whose lobe is drawn: one of 0.01 is as
/// wide as a pixel of a sphere.
inline constexpr double kLeastLobe = 0.01;

/// The reflection of a stack at any pair of directions, fast enough for a picture: what is closed,
/// exactly, plus an interpolated table of the rest. Where the stack is not symmetric about z there
/// is a table for each of kSectors azimuths of w_o, for each side of its plane, and f is linear
/// between them. Closed are order 1,
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
  [[nodiscard]] bool has_specular() const;

  /// Tables of several stacks are interpolated in two parts: what of f is closed, of any of these
  /// stacks, and what each table has beside it. `drawn`: by drawn_stack. The kind of what is closed
  /// must be the same (is_like).
  [[nodiscard]] Rgb closed_of(const Stack& drawn, Direction wi, Direction wo) const;
  [[nodiscard]] std::function<Rgb(Direction wi)> rest_towards(Direction wo) const;
  [[nodiscard]] bool is_like(const LobeTable& other) const { return closed_ == other.closed_; }
  /// The stack with smooth surfaces for those whose lobes are too narrow to be drawn.
  [[nodiscard]] static Stack drawn_stack(Stack stack);

  /// How the table was made, for people.
  [[nodiscard]] const std::string& source() const { return source_; }

  /// Whether f depends on the azimuth of w_o.
  [[nodiscard]] bool has_azimuth() const;
  static constexpr int kSectors = 16;

  /// By adding and doubling, or in spherical harmonics where the stack is not symmetric about z,
  /// where these apply and reach a small enough error (the estimator `auto`); else by as many
  /// next-event walks per outgoing node as are asked for. A request's tolerance above 1e-4 is the
  /// solver's. For stacks that `check_preview` lets pass.
  [[nodiscard]] static LobeTable make(const TruthRequest& request, const StopFlag* stop,
                                      const SolverReport& report = {});

  /// The mean of tables, each with its share of 1; `source`: of all of them. It is seen by
  /// `towards` and `specular`; the two parts of f that tables are interpolated in are the tables'.
  struct Share {
    std::shared_ptr<const LobeTable> table;
    double share;
  };
  [[nodiscard]] static LobeTable mean(std::vector<Share> shares, std::string source);

 private:
  // What of f is known in closed form; the table has the rest.
  enum class Closed { order_one, zero, nothing };
  // The share of light from a node's direction that leaves on its side by what the table holds, by
  // two ways, with their errors.
  struct RestEnergy {
    Rgb direct, direct_error;  // those orders' own
    Rgb total, total_error;    // of all orders without deltas: less the closed form's energy
  };
  // Of one azimuth of w_o.
  struct Sector {
    double azimuth = 0;
    HalfVectorGrid rest;                 // what is not closed; w_i to the left of w_o's plane
    HalfVectorGrid right{};              // to the right of it, where the stack is not symmetric
    std::vector<Rgb> scales{};           // of them at every node in mu_o and between two
    std::vector<RestEnergy> energies{};  // of the nodes in mu_o
  };
  // w_o of a node, and w_i of one; side: 0 left, 1 right.
  [[nodiscard]] static Direction outgoing(const Sector& sector, int out);
  [[nodiscard]] static Direction incoming(const Sector& sector, int out, int alpha, int beta,
                                          int side);
  [[nodiscard]] int sides() const { return has_azimuth() ? 2 : 1; }
  [[nodiscard]] std::function<Rgb(Direction)> rest_towards(const Sector& sector,
                                                           Direction wo) const;
  // Whether another sector's table, mirrored, is that of sector k, which it then is.
  [[nodiscard]] bool mirror_sector(int k);
  void solve_in_harmonics(const TruthRequest& request, const StopFlag* stop);
  void scale_to_energies(Sector& sector, const StopFlag* stop);
  [[nodiscard]] Rgb closed(Direction wi, Direction wo) const { return closed_of(stack_, wi, wo); }
  // Why the solver has no answer, if it has none, or one that is not near enough and no `must`.
  std::optional<std::string> solve(const TruthRequest& request, bool must, const StopFlag* stop,
                                   const SolverReport& report);
  void walk(const TruthRequest& request, const StopFlag* stop);

  Stack stack_;
  Closed closed_ = Closed::order_one;
  std::vector<Sector> tables_{1};  // one, or kSectors
  SectorSymmetry symmetry_{};
  std::string source_;
  std::vector<Share> shares_{};  // of a mean, which has nothing else
};

/// Throws UsageError, which names `what` asked for the table, for a stack whose reflection the
/// table cannot hold: one that is explicit geometry, has a grid, one-sided flakes whose mean normal
/// is not vertical, or a substrate whose closed form is not reciprocal. `texels`: stacks whose mean
/// is drawn in its place, if there are any.
void check_preview(const std::string& what, const Stack& stack,
                   const std::vector<Stack>& texels = {});

}  // namespace lamella
