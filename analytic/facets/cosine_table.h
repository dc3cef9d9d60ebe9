#pragma once

#include <functional>
#include <vector>

namespace lamella {

/// A function of a cosine in [0, 1] as polynomials of `terms` coefficients on panels that halve
/// towards 0: [1/2, 1], [1/4, 1/2], ..., the last one [0, h], h at most `finest`. For functions
/// that are analytic but near mu = 0, as directional albedos of rough surfaces are, which go like
/// mu log mu there: the relative error is 6^-terms where it changes by itself, and `finest` at 0.
class CosineTable {
 public:
  CosineTable() = default;
  CosineTable(const std::function<double(double mu)>& f, double finest, int terms);

  /// The function at mu in [0, 1].
  [[nodiscard]] double operator()(double mu) const;
  /// 2 integral of f(mu) mu dmu: the mean over a hemisphere, cosine-weighted.
  [[nodiscard]] double mean() const { return mean_; }

 private:
  int terms_ = 0;
  std::vector<double> coefficients_;  // Chebyshev's, `terms_` per panel, that at 1 first
  int last_ = 0;                      // the panel that ends at 0
  double mean_ = 0;
};

}  // namespace lamella
