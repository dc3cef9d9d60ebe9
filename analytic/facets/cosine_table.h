#pragma once

#include <functional>
#include <vector>

namespace lamella {

/// A function of a cosine in [0, 1] as polynomials of `terms` coefficients on panels that halve
/// towards both ends: [1/4, 1/2], [1/8, 1/4], ..., [0, h] with h at most `near_0`, and the same in
/// 1 - mu with `near_1`. For functions that are analytic but at the ends, as directional albedos of
/// rough surfaces are, which go like mu log mu near 0: the relative error is 6^-terms within, and
/// at the ends that of h.
class CosineTable {
 public:
  CosineTable() = default;
  CosineTable(const std::function<double(double mu)>& f, int terms, double near_0, double near_1);

  /// The function at mu in [0, 1].
  [[nodiscard]] double operator()(double mu) const;
  /// 2 integral of f(mu) mu dmu: the mean over a hemisphere, cosine-weighted.
  [[nodiscard]] double mean() const { return mean_; }

 private:
  // Panel k of a half: at the distance from its end [2^-(k + 2), 2^-(k + 1)], the last from 0.
  struct Half {
    int last = 0;
    std::vector<double> coefficients{};  // Chebyshev's, `terms_` per panel
  };
  void fill(Half& half, bool upper, const std::function<double(double mu)>& f, double finest);
  [[nodiscard]] double at(const Half& half, double distance) const;

  int terms_ = 0;
  Half lower_, upper_;
  double mean_ = 0;
};

}  // namespace lamella
