#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <vector>

#include "phase/interface/interfaces.h"
#include "phase/surface/surface_law.h"
#include "volume/algebra/matrix_product.h"
#include "volume/harmonics/face_light.h"
#include "volume/quadrature/direction_sets.h"

namespace lamella {

/// A rough boundary, or an opaque ground, that is not symmetric about the normal: its BSDF between
/// waves in the azimuth, all of which it couples, at the nodes of the media on both sides. As those
/// of FacetModes, values at nodes are moments: u^3 times the radiance is a polynomial on each panel
/// of nodes, and the BSDF is taken at several times as many cosines. Light that meets a ground
/// meets one event; at an interface it keeps its order. Where x and y are axes of symmetry, as of
/// facets, cosines keep from sines and even waves from odd ones.
class AnisotropicBoundary {
 public:
  /// The BSDF between waves, which all channels of an interface share: by way through it and class
  /// of waves.
  struct Operators {
    struct OfClass {
      Eigen::MatrixXd nodes;  // (wave, node) from (wave, node), irradiance in
      Eigen::MatrixXd asked;  // (wave, asked cosine) from (wave, node)
    };
    std::vector<std::vector<OfClass>> by_way;
  };
  /// Single scattering at the facets of an interface. degree: the highest wave that is kept. The
  /// sets must outlive the object. operators: those of the same interface, sets and degree.
  AnisotropicBoundary(const Interface& interface, const DirectionSets& above,
                      const DirectionSets& below, int degree, const MatrixProduct& product,
                      std::shared_ptr<const Operators> operators = nullptr);
  /// A ground below a medium, in one channel.
  AnisotropicBoundary(std::shared_ptr<const SurfaceLaw> law, int channel,
                      const DirectionSets& above, int degree, const MatrixProduct& product);

  /// By how much it raises the order of light.
  [[nodiscard]] int raise() const { return is_open_ ? 0 : 1; }

  /// What leaves it where waves arrive at the nodes: down from above it, up from below it. Rows of
  /// the answer: those of the sets; of the asked ones nothing (see `add_asked`).
  [[nodiscard]] FaceLight from(const FaceLight& arriving) const;
  /// The same along asked cosines: adds to `leaving`, one entry per entry of `arriving`.
  void add_asked(const std::vector<FaceLight>& arriving, std::vector<FaceLight>& leaving) const;
  /// Of a beam of number `in` of the asked ones, by the azimuth of its way and the power from
  /// either side. Between two asked directions an interface leaves out what ClosedOrders has.
  [[nodiscard]] FaceLight from_beam(double azimuth, Eigen::Index in, double down, double up,
                                    Eigen::Index waves) const;

  struct Taken {
    double absorbed = 0, lost = 0;
  };
  [[nodiscard]] Taken taken(const FaceLight& arriving) const;
  [[nodiscard]] Taken taken_of_beam(double azimuth, Eigen::Index in, double down, double up) const;

  [[nodiscard]] const std::shared_ptr<const Operators>& operators() const { return operators_; }
  /// Bytes that its operators hold.
  [[nodiscard]] std::size_t bytes() const;

 private:
  // Ways through the boundary, by where light comes from and goes.
  struct Way {
    bool from_above, to_above;
  };
  [[nodiscard]] const DirectionSets& set(bool is_above) const {
    return is_above ? *above_ : *below_;
  }
  [[nodiscard]] std::vector<Way> ways() const;
  // Waves that symmetry keeps from all others.
  void find_classes(int degree);
  void make_operators();
  void make_nodes(Way way, std::vector<Operators::OfClass>& all) const;
  void make_asked(Way way, std::vector<Operators::OfClass>& all) const;
  void find_absorbed();
  // Cosines between nodes, and what light there is at the nodes.
  struct Between {
    Eigen::VectorXd mu, flux;  // 2 pi mu times the weight
    Eigen::MatrixXd of_nodes;  // radiance at the cosines (rows) by that at the nodes (columns)
  };
  // cut: a cosine at which the BSDF jumps, or 0.
  [[nodiscard]] static Between between(const DirectionSets& sets, int finer, double cut);
  // The cosine in `there` beyond which facets that refract from or to |mu| of `here` stand upright.
  [[nodiscard]] static double upright(Way way, const DirectionSets& here,
                                      const DirectionSets& there, double mu);
  // f between waves of each class at these cosines.
  [[nodiscard]] std::vector<Eigen::MatrixXd> between_waves(Way way, double mu_in,
                                                           double mu_out) const;
  [[nodiscard]] Direction leaving(bool up, double mu, int p) const;
  // Adds what an operator's part makes of light of one way to rows first, ... of the answer.
  void add(const Eigen::MatrixXd& of_class, const std::vector<Eigen::Index>& waves,
           const Eigen::MatrixXd& irradiance, Eigen::Index first, Eigen::MatrixXd& answer) const;

  const DirectionSets *above_, *below_;
  bool is_open_;
  int azimuths_;
  Eigen::VectorXd cosines_, sines_;  // of the azimuths
  MatrixProduct product_;
  bool has_axes_ = true;  // x and y are axes of symmetry, as of facets
  std::function<double(Direction wi, Direction wo)> f_;
  /// Share that is absorbed of what arrives from w_i; empty: what does not leave.
  std::function<double(Direction wi)> absorbed_;
  Eigen::MatrixXd waves_;                           // rows: azimuths, columns: waves
  std::vector<std::vector<Eigen::Index>> classes_;  // the waves of each
  Eigen::MatrixXd back_;                   // to waves, class by class, from azimuths of what leaves
  std::vector<Eigen::MatrixXd> arriving_;  // from waves of a class to azimuths of what arrives
  std::shared_ptr<const Operators> operators_;
  Eigen::MatrixXd absorbed_waves_;  // rows: nodes
};

}  // namespace lamella
