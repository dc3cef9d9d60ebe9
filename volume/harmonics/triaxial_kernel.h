#pragma once

#include <Eigen/Core>
#include <vector>

#include "phase/medium/sggx.h"
#include "volume/harmonics/harmonic_turn.h"

namespace lamella {

/// The kernel of flakes whose S has three distinct eigenvalues, in harmonics about its axes: those
/// of cosines and sines, of even and odd m, and of even and odd l keep apart.
class TriaxialKernel {
 public:
  /// mirrors: or Lambertian flakes. f0: Schlick's, of mirrors. normals: SGGX.
  TriaxialKernel(const Sggx& normals, bool mirrors, double f0, const HarmonicBasis& basis,
                 MatrixProduct product);

  /// As HarmonicKernel::apply.
  [[nodiscard]] Eigen::MatrixXd apply(const Eigen::MatrixXd& radiance) const;

 private:
  struct Block {
    std::vector<int> places;  // in the basis
    Eigen::MatrixXd matrix;
  };
  MatrixProduct product_;
  HarmonicTurn turn_;
  std::vector<Block> blocks_;
};

}  // namespace lamella
