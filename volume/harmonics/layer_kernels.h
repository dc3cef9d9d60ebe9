#pragma once

#include <memory>
#include <vector>

#include "phase/medium/medium.h"
#include "volume/harmonics/harmonic_kernel.h"

namespace lamella {

/// The kernels of a stack's layers at one degree, made when they are first asked for: colour
/// channels differ in their albedos, and seldom in f0, so that they share them, as layers of one
/// medium do. Copies share what they made. For one thread.
class LayerKernels {
 public:
  LayerKernels(const HarmonicBasis& basis, MatrixProduct product)
      : basis_(basis), product_(product) {}

  [[nodiscard]] const HarmonicBasis& basis() const { return basis_; }
  [[nodiscard]] MatrixProduct product() const { return product_; }

  [[nodiscard]] std::shared_ptr<const HarmonicKernel> of(const Medium& medium, double f0) const {
    for (const Made& made : *made_)
      if (made.f0 == f0 && made.medium == medium) return made.kernel;
    made_->push_back(
        {medium, f0, std::make_shared<const HarmonicKernel>(medium, f0, basis_, product_)});
    return made_->back().kernel;
  }

 private:
  struct Made {
    Medium medium;
    double f0;
    std::shared_ptr<const HarmonicKernel> kernel;
  };

  HarmonicBasis basis_;
  MatrixProduct product_;
  std::shared_ptr<std::vector<Made>> made_ = std::make_shared<std::vector<Made>>();
};

}  // namespace lamella
