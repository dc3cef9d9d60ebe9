#pragma once

#include <array>
#include <cstddef>
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
/// 8 points of Gauss and Legendre on panels that are halved until Bernstein's ellipse of sum of
/// half axes 3.4 about each of them holds no singularity, so that they leave about 3e-9.
class CirclePanels {
 public:
  /// The whole circle. longest: of a panel [radians].
  void place(const std::vector<CircleZero>& zeros, double longest);
  /// An arc whose ends lie on the horizon, where what light meets along its way varies over the
  /// azimuth `near` and, beyond it, over the distance from the end.
  void place_arc(double begin, double end, double near, const std::vector<CircleZero>& zeros,
                 double longest);

  [[nodiscard]] int size() const { return static_cast<int>(half_.size()); }
  /// Of the panels' middles, and half their lengths, at most pi / 4.
  [[nodiscard]] const double* cosines() const { return cosine_.data(); }
  [[nodiscard]] const double* sines() const { return sine_.data(); }
  [[nodiscard]] const double* halves() const { return half_.data(); }

 private:
  struct Arc {
    double begin, end, near;
  };
  struct Panel {
    double middle, cosine, sine;
  };
  // Half the length of a panel by number of halvings, with its cosine and sine.
  struct Half {
    double length, cosine, sine;
  };

  void clear();
  void add_range(double from, double to, const Arc* arc, const std::vector<CircleZero>& zeros,
                 double longest);
  void add(const Panel& panel, std::size_t halvings, const Arc* arc,
           const std::vector<CircleZero>& zeros, double longest);

  static constexpr std::size_t kHalvings = 28;
  std::array<Half, kHalvings + 1> halvings_{};
  std::size_t known_ = 0;  // of halvings_
  std::vector<double> cosine_, sine_, half_;
};

}  // namespace lamella
