#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <vector>

#include "volume/harmonics/legendre_patch.h"
#include "volume/harmonics/mirror_pairs.h"

namespace lamella {

/// What mirrors that share an axis scatter twice, over all directions of one side, as polynomials
/// on parts of polar angle and azimuth about that axis. There f is narrow in the polar angle alone
/// and has its kinks at constant ones, those of w_i, so that the parts are few whatever the grid
/// of cells is. Azimuths are counted from where circles are highest, in the length of the arc above
/// the horizon; parts shrink towards the horizon, where f behaves like mu log mu, and where circles
/// touch it.
class PairField {
 public:
  /// Whether all mirrors share an axis that is not the normal.
  [[nodiscard]] static bool applies(const MirrorPairs& pairs);
  /// Values that a part takes, of those that are halved with it.
  static constexpr int kValuesOfPart = LegendrePatch::kAlong * (LegendrePatch::kAlong + 5);
  /// About how many values a field takes. tolerance: relative to f. width: of the kernel [radians].
  [[nodiscard]] static double expected_pairs(const MirrorPairs& pairs, Direction wi,
                                             double tolerance, double width);

  /// up: whether w_o.z > 0. tolerance: absolute [1/sr], by |mu_o|. Once `stop` is set the field is
  /// not whole. pairs: only used here. The same bits on any number of threads.
  PairField(const MirrorPairs& pairs, Direction wi, bool up,
            const std::function<double(double mu)>& tolerance, const std::atomic<bool>* stop);
  ~PairField();
  PairField(PairField&&) noexcept;

  [[nodiscard]] bool is_whole() const { return is_whole_; }
  struct Value {
    Rgb f;
    double error;  ///< absolute, of any channel
  };
  /// wo: on the side of the field.
  [[nodiscard]] Value at(Direction wo) const;
  /// Parts of all polynomials.
  [[nodiscard]] int parts() const;

 private:
  struct Part;
  struct Builder;

  // An interval of the polar angle; q from 0 to 1 is what its points are even in.
  struct Band {
    double from, to;
    bool crowds_at_from, crowds_at_to;
    std::vector<std::unique_ptr<Part>> roots{};

    [[nodiscard]] double theta(double q) const;
    [[nodiscard]] double q(double theta) const;
  };
  // Root, and place within it.
  struct Place {
    int root;
    double p;
  };

  [[nodiscard]] static bool folds_phi(const MirrorLayers& layers, Direction wi);
  [[nodiscard]] static bool folds_theta(const MirrorLayers& layers, Direction wi);
  [[nodiscard]] Direction direction(double theta, double phi) const;
  [[nodiscard]] Direction within(Direction w) const;
  [[nodiscard]] double end_of_arc(double theta) const;
  [[nodiscard]] double azimuth_at(int root, double theta, double p) const;
  [[nodiscard]] Place place(double theta, double phi) const;
  [[nodiscard]] int roots() const;

  Frame<double> frame_;            // s: where circles are highest
  double height_ = 0, swing_ = 1;  // mu = height cos(theta) + swing sin(theta) cos(phi)
  bool is_up_;
  bool folds_phi_ = false, folds_theta_ = false;
  bool is_whole_ = true;
  std::vector<Band> bands_;
};

}  // namespace lamella
