#pragma once

#include <Eigen/Core>

#include "phase/lanes/isa.h"

namespace lamella {

/// Products of matrices on the lanes of an instruction set. The same for every machine that has the
/// set, and for any number of threads; Isa::scalar: Eigen's own product.
class MatrixProduct {
 public:
  explicit MatrixProduct(Isa isa = Isa::scalar) : isa_(isa) {}

  [[nodiscard]] Eigen::MatrixXd operator()(const Eigen::Ref<const Eigen::MatrixXd>& a,
                                           const Eigen::Ref<const Eigen::MatrixXd>& b) const;
  /// c += a b. c must not share memory with a or b.
  void add(const Eigen::Ref<const Eigen::MatrixXd>& a, const Eigen::Ref<const Eigen::MatrixXd>& b,
           Eigen::Ref<Eigen::MatrixXd> c) const;

 private:
  Isa isa_;
};

}  // namespace lamella
