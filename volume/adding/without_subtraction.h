#pragma once

#include <Eigen/Core>

namespace lamella {

/// Solves (I - P) D = B for P >= 0 whose columns sum to 1 - defect, defect >= 0, all in irradiance:
/// elimination on off-diagonal entries and the defect alone (Grassmann, Taksar and Heyman 1985), so
/// that nothing of one sign is subtracted and every entry of D keeps its digits where the defect is
/// close to 0. Nodes that light never gets to (pivot 0) answer 0.
class WithoutSubtraction {
 public:
  WithoutSubtraction(const Eigen::MatrixXd& product, const Eigen::RowVectorXd& defect);

  [[nodiscard]] Eigen::MatrixXd solve(Eigen::MatrixXd b) const;

 private:
  Eigen::MatrixXd a_;
  Eigen::VectorXd pivot_;
};

}  // namespace lamella
