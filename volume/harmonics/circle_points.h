#pragma once

#include <vector>

namespace lamella {

/// Zeros in the complex plane of real trigonometric polynomials, by azimuth [radians] and distance
/// from the real line.
struct CircleZero {
  double phi, distance;
};

/// Of a + b cos phi + c sin phi that is nowhere below 0; nothing where it is constant.
void add_zeros(double a, double b, double c, std::vector<CircleZero>& zeros);
/// Of a + b cos phi + c sin phi + d cos 2 phi + e sin 2 phi that is nowhere below 0: to about a
/// hundredth of their distance.
void add_zeros(double a, double b, double c, double d, double e, std::vector<CircleZero>& zeros);

/// Quadrature over the azimuth of functions whose singularities in the complex plane are known:
/// Gauss-Legendre on parts that are halved until Bernstein's ellipse of sum of half axes 3 about
/// each of them holds no singularity, so that n points leave about 9^-n.
class CirclePoints {
 public:
  /// The number of points is a multiple of `together`; those that fill it up weigh nothing.
  CirclePoints(int points_per_part, int together);

  /// longest: of a part [radians].
  void place(const std::vector<CircleZero>& zeros, double longest);
  [[nodiscard]] int size() const { return static_cast<int>(weight_.size()); }
  [[nodiscard]] const double* cosines() const { return cosine_.data(); }
  [[nodiscard]] const double* sines() const { return sine_.data(); }
  [[nodiscard]] const double* weights() const { return weight_.data(); }

 private:
  static constexpr int kHalvings = 28;
  static constexpr int kFirstParts = 4;

  void add(double middle, int halvings, const std::vector<CircleZero>& zeros, double longest);

  int points_, together_;
  // By number of halvings: cosine, sine and weight of the points about a part's middle.
  std::vector<double> cosines_, sines_, weights_;
  std::vector<double> cosine_, sine_, weight_;
};

}  // namespace lamella
