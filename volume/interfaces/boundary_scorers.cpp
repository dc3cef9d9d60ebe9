#include "volume/interfaces/boundary_scorers.h"

namespace lamella {

template <int C>
BoundaryNextEvent<C>::BoundaryNextEvent(const BoundaryStack& stack, const CellTargets& cells,
                                        BatchTally& tally)
    : stack_(stack),
      cells_(&cells),
      tally_(tally),
      redrawn_(cells),
      count_(cells.count()),
      x_(count_),
      y_(count_),
      z_(count_),
      inverse_mu_(count_),
      ways_(stack) {}

template <int C>
BoundaryNextEvent<C>::BoundaryNextEvent(const BoundaryStack& stack,
                                        const std::vector<Direction>& points, BatchTally& tally,
                                        AimedShare share)
    : stack_(stack), tally_(tally), share_(share), count_(points.size()), ways_(stack, true) {
  for (const Direction& w : points) {
    x_.push_back(w.x);
    y_.push_back(w.y);
    z_.push_back(w.z);
  }
}

template <int C>
void BoundaryNextEvent<C>::begin_walk(std::uint64_t seed, std::uint64_t index) {
  // The walks i of a batch are batch + i kBatches: a group begins at the same walk in any split.
  const std::uint64_t in_batch = index / kBatches;
  const std::uint64_t group = index - in_batch % kWalksPerWay * kBatches;
  if (traced_ && group == group_) return;
  // Ways without chance are the same for all walks to the same points.
  if (traced_ && !redrawn_ && !ways_.is_random()) return;
  seed_ = seed;
  group_ = group;
  traced_ = false;
}

template <int C>
const ExitPaths& BoundaryNextEvent<C>::ways() {
  if (traced_) return ways_;
  if (redrawn_) redrawn_->redraw(seed_, group_, x_, y_, z_, inverse_mu_);
  RandomStream stream(seed_, group_, StreamPurpose::ways);
  ways_.clear();
  for (std::size_t j = 0; j < count_; ++j)
    ways_.trace({x_[j], y_[j], z_[j]}, static_cast<int>(j), stream);
  traced_ = true;
  return ways_;
}

template <int C>
void BoundaryNextEvent<C>::substrate(const std::array<double, C>& weight,
                                     const std::array<double, C>& albedo, std::uint64_t order) {
  const ExitPaths::Ends& ends = ways().at_substrate();
  double* sums = sums_of(order);
  for (std::size_t j = 0; j < ends.count(); ++j) {
    const double share = share_.of([&] {
      return kLambertSubstrate.density({0, 0, ends.z[j]}).density;
    });
    const double transport = share * lambert_radiance(ends.through[j]);
    for (int c = 0; c < C; ++c)
      sums[c * count_ + ends.target[j]] += weight[c] * albedo[c] * transport;
  }
}

template <int C>
void BoundaryNextEvent<C>::substrate(const std::array<double, C>& weight, const SurfaceLaw& law,
                                     Direction wi, std::uint64_t order, RandomStream& stream) {
  const ExitPaths::Ends& ends = ways().at_substrate();
  double* sums = sums_of(order);
  double checksum = 0;
  for (std::size_t j = 0; j < ends.count(); ++j) {
    const Direction w{ends.x[j], ends.y[j], ends.z[j]};
    const Rgb f = share_.of([&] { return law.density(wi, w); }) * law.eval(wi, w, stream);
    for (int c = 0; c < C; ++c) {
      checksum += f[c];
      sums[c * count_ + ends.target[j]] += weight[c] * f[c] * ends.through[j];
    }
  }
  finite_ = finite_ && std::isfinite(checksum);
}

template <int C>
bool BoundaryNextEvent<C>::interface(int boundary, const Dielectric& at, Direction wi,
                                     const std::array<double, C>& weight, std::uint64_t order,
                                     RandomStream& stream) {
  if (cells_) return false;
  double checksum = 0;
  constexpr std::array<double, 3> kWhole{1, 1, 1};
  const auto send = [&](Direction w, double through, int target, std::uint64_t mirrors,
                        const std::array<double, 3>& mirrored) {
    if (!(through > 0) || order + mirrors > stack_.max_order) return;
    const double share = share_.of([&] { return at.single_density(wi, w); });
    const double f = share * at.eval(wi, w, stream) * through;
    checksum += f;
    double* sums = sums_of(order + mirrors);
    for (int c = 0; c < C; ++c) sums[c * count_ + target] += weight[c] * f * mirrored[c];
  };
  const auto send_along = [&](int layer, bool up) {
    const bool outermost = layer < 0 || layer >= stack_.count();
    if (outermost) {
      for (std::size_t j = 0; j < count_; ++j)
        if ((z_[j] > 0) == up) send({x_[j], y_[j], z_[j]}, 1, static_cast<int>(j), 0, kWhole);
      return;
    }
    const ExitPaths::Segments& s = ways().in_layer(layer);
    const double depth = stack_.layers[layer].depth;
    const bool mirrored = !s.mirrors.empty();
    for (std::size_t j = 0; j < s.count(); ++j)
      if ((s.z[j] > 0) == up)
        send({s.x[j], s.y[j], s.z[j]},
             s.through[j] * (s.rate[j] > 0 ? std::exp(-s.rate[j] * depth) : 1), s.target[j],
             mirrored ? s.mirrors[j] : 0, mirrored ? s.mirrored[j] : kWhole);
  };
  send_along(boundary - 1, true);
  send_along(boundary, false);
  finite_ = finite_ && std::isfinite(checksum);
  return true;
}

template class BoundaryNextEvent<1>;
template class BoundaryNextEvent<3>;

}  // namespace lamella
