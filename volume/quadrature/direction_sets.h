#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "volume/quadrature/quadrature.h"

namespace lamella {

/// Consecutive nodes of a hemisphere that one map makes from u in (0, 1). Where a stack has several
/// indices of refraction, each of them, n_k, ends a panel: in its own medium, the panel's home, at
/// grazing; the next rarer one, n_(k-1), begins it, at the critical angle. The nodes of denser
/// media are those of the home by Snell's law, so that no panel crosses a critical angle.
struct NodePanel {
  Eigen::Index first = 0, count = 0;
  GrazingMap map;
  double reach = 1;  ///< largest cosine at home: mu = reach * map.mu(u)
  double ratio = 1;  ///< index at home over that of the medium, at most 1

  [[nodiscard]] double mu(double u) const;
  [[nodiscard]] double slope(double u) const;  ///< d mu / du
  /// u of a cosine, beyond (0, 1) clamped.
  [[nodiscard]] double parameter(double mu) const;
  /// The cosines at u = 0 and u = 1.
  [[nodiscard]] double low() const { return mu(0); }
  [[nodiscard]] double high() const { return mu(1); }
};

/// A direction that is asked for: |mu| in a medium of that index.
struct AskedCosine {
  double mu, index;
};

/// The indices of refraction that occur in a stack, and how finely their hemispheres are resolved.
struct RefractiveNodes {
  std::vector<double> indices;  ///< distinct, ascending
  int nodes = 8;                ///< of the rarest medium; denser ones have more
  GrazingMap map{};
};

/// The directions that one solution works with: quadrature nodes first, then directions that are
/// asked for, which have no weight and so only receive the source function (out) or only send a
/// beam (in). All are |mu|; mu = 0 stands as kGrazingLimit.
struct DirectionSets {
  Eigen::VectorXd out, in;
  Eigen::VectorXd weight;  ///< of the nodes, for the integral over mu in (0, 1)
  Eigen::VectorXd flux;    ///< 2 pi mu weight: radiance of mode 0 to irradiance

  std::vector<NodePanel> panels;  ///< of the nodes
  double index = 1;               ///< of refraction of the medium
  /// For directions that are asked for: whether they exist in this medium by Snell's law. A
  /// direction that does not is totally reflected before, and its cosine here has no meaning.
  /// Empty: all exist.
  std::vector<bool> out_exists, in_exists;

  DirectionSets(int nodes, const std::vector<double>& extra_out,
                const std::vector<double>& extra_in, const GrazingMap& grazing_map = {});
  /// Those of a medium of that index, one of nodes.indices. Nodes that media share are the same
  /// directions by Snell's law, come first, and carry the same flux times index^2.
  DirectionSets(const RefractiveNodes& nodes, double index, std::span<const AskedCosine> asked_out,
                std::span<const AskedCosine> asked_in);

  [[nodiscard]] Eigen::Index nodes() const { return weight.size(); }
};

/// The cosine in a medium of index `to` of a direction with cosine mu in one of index `from`, by
/// Snell's law; 0 where it is totally reflected.
[[nodiscard]] double snell_cosine(double mu, double from, double to);

}  // namespace lamella
