#pragma once

#include <map>
#include <memory>
#include <utility>

#include "phase/stack/stack.h"
#include "volume/harmonics/harmonic_kernel.h"

namespace lamella {

/// The kernels of a stack's layers at one degree, made when they are first asked for: colour
/// channels differ in their albedos, and seldom in f0, so that they share them. Copies share
/// what they made. For one thread.
class LayerKernels {
 public:
  LayerKernels(const HarmonicBasis& basis, MatrixProduct product)
      : basis_(basis), product_(product) {}

  [[nodiscard]] const HarmonicBasis& basis() const { return basis_; }
  [[nodiscard]] MatrixProduct product() const { return product_; }

  /// The layer is known by its address.
  [[nodiscard]] std::shared_ptr<const HarmonicKernel> of(const Layer& layer, double f0) const {
    std::shared_ptr<const HarmonicKernel>& kernel = (*kernels_)[{&layer, f0}];
    if (!kernel)
      kernel = std::make_shared<const HarmonicKernel>(layer.medium, f0, basis_, product_);
    return kernel;
  }

 private:
  HarmonicBasis basis_;
  MatrixProduct product_;
  using Map = std::map<std::pair<const Layer*, double>, std::shared_ptr<const HarmonicKernel>>;
  std::shared_ptr<Map> kernels_ = std::make_shared<Map>();
};

}  // namespace lamella
