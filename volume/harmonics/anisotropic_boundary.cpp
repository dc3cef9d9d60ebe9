#include "volume/harmonics/anisotropic_boundary.h"

#include <tbb/parallel_for.h>

#include <cmath>

#include "phase/interface/dielectric.h"
#include "phase/math/direction.h"
#include "phase/surface/conductor.h"
#include "volume/adding/rough_boundary.h"
#include "volume/kernel/forward_projection.h"

namespace lamella {
namespace {

using Eigen::Index;
using Eigen::Map;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// A multiple of 4, so that the grid has the symmetry of facets.
int azimuths_for(int degree) { return 4 * ((2 * degree + 19) / 4); }

VectorXd even_azimuths(int count) {
  VectorXd phi(count);
  for (int p = 0; p < count; ++p) phi[p] = 2 * kPi * p / count;
  return phi;
}

// Times as many cosines as nodes: between nodes; for a beam, whose lobe nothing has smoothed.
constexpr int kFiner = 3, kFinest = 8;

bool exists(const std::vector<bool>& list, Index asked) {
  return list.empty() || list[static_cast<std::size_t>(asked)];
}

}  // namespace

MatrixXd azimuthal_waves(Index waves, const VectorXd& phi) {
  MatrixXd values(phi.size(), waves);
  for (Index p = 0; p < phi.size(); ++p) {
    values(p, 0) = 1;
    for (Index m = 1; 2 * m < waves; ++m) {
      const double angle = static_cast<double>(m) * phi[p];
      values(p, 2 * m - 1) = std::sqrt(2.0) * std::cos(angle);
      values(p, 2 * m) = std::sqrt(2.0) * std::sin(angle);
    }
  }
  return values;
}

AnisotropicBoundary::AnisotropicBoundary(const Interface& interface, const DirectionSets& above,
                                         const DirectionSets& below, int degree,
                                         const MatrixProduct& product)
    : above_(&above),
      below_(&below),
      is_open_(true),
      azimuths_(azimuths_for(degree)),
      product_(product),
      waves_(azimuthal_waves(2 * degree + 1, even_azimuths(azimuths_))) {
  const Dielectric boundary{.facets = interface.facets,
                            .masking = interface.masking,
                            .multiple = false,
                            .above = above.index,
                            .below = below.index};
  f_ = [boundary](Direction wi, Direction wo) { return boundary.single(wi, wo); };
  absorbed_ = [](Direction) { return 0.0; };
  make_operators();
}

AnisotropicBoundary::AnisotropicBoundary(std::shared_ptr<const SurfaceLaw> law, int channel,
                                         const DirectionSets& above, int degree,
                                         const MatrixProduct& product)
    : above_(&above),
      below_(&above),
      is_open_(false),
      azimuths_(azimuths_for(degree)),
      product_(product),
      waves_(azimuthal_waves(2 * degree + 1, even_azimuths(azimuths_))) {
  f_ = [law, channel](Direction wi, Direction wo) {
    RandomStream unused(0, 0, StreamPurpose::walk);
    return law->eval(wi, wo, unused)[channel];
  };
  const auto* conductor = dynamic_cast<const Conductor*>(law.get());
  has_axes_ = conductor != nullptr;
  if (conductor)
    absorbed_ = [law, conductor, channel](Direction wi) {
      const Conductor::Setting& s = conductor->setting();
      if (s.white) return 0.0;
      return 1 - std::min(1.0, met_by_facets(
                                   s.facets,
                                   [&](double cosine) {
                                     return conductor->reflectance(cosine)[channel];
                                   },
                                   wi));
    };
  make_operators();
}

std::size_t AnisotropicBoundary::bytes() const {
  Index entries = 0;
  for (const MatrixXd& m : operators_) entries += m.size();
  return static_cast<std::size_t>(entries) * sizeof(double);
}

std::vector<AnisotropicBoundary::Way> AnisotropicBoundary::ways() const {
  if (!is_open_) return {{true, true}};
  return {{true, true}, {true, false}, {false, false}, {false, true}};
}

Direction AnisotropicBoundary::leaving(bool up, double mu, int p) const {
  return direction_from_mu_phi(up ? mu : -mu, 2 * kPi * p / azimuths_);
}

AnisotropicBoundary::Between AnisotropicBoundary::between(const DirectionSets& sets, int finer,
                                                          double cut) {
  // By panel the ends of the parts that have a rule of their own, in u.
  const auto parts_of = [&](const NodePanel& panel) {
    std::vector<double> ends{0, 1};
    const double u = cut > panel.low() && cut < panel.high() ? panel.parameter(cut) : 0;
    if (u > 0 && u < 1) ends.insert(ends.begin() + 1, u);
    return ends;
  };
  Index size = 0;
  for (const NodePanel& panel : sets.panels)
    size += finer * panel.count * static_cast<Index>(parts_of(panel).size() - 1);
  Between fine{VectorXd(size), VectorXd(size), MatrixXd::Zero(size, sets.nodes())};
  Index place = 0;
  for (const NodePanel& panel : sets.panels) {
    const Quadrature& nodes = cached_gauss_legendre(static_cast<int>(panel.count));
    const Quadrature& rule = cached_gauss_legendre(static_cast<int>(finer * panel.count));
    const std::vector<double> ends = parts_of(panel);
    for (std::size_t part = 0; part + 1 < ends.size(); ++part) {
      const double length = ends[part + 1] - ends[part];
      const VectorXd points = (ends[part] + length * rule.points.array()).matrix();
      const MatrixXd lagrange = lagrange_values(nodes, points);
      for (Index k = 0; k < points.size(); ++k, ++place) {
        const double u = points[k];
        fine.mu[place] = panel.mu(u);
        fine.flux[place] = 2 * kPi * fine.mu[place] * panel.slope(u) * length * rule.weights[k];
        for (Index j = 0; j < panel.count; ++j) {
          const double ratio = nodes.points[j] / u;
          fine.of_nodes(place, panel.first + j) = lagrange(k, j) * ratio * ratio * ratio;
        }
      }
    }
  }
  return fine;
}

double AnisotropicBoundary::upright(Way way, const DirectionSets& here, const DirectionSets& there,
                                    double mu) {
  return way.from_above == way.to_above ? 0 : mu * here.index / there.index;
}

MatrixXd AnisotropicBoundary::values(Way way, double mu_in, double mu_out) const {
  MatrixXd f(azimuths_, azimuths_);
  const int half = azimuths_ / 2, last = has_axes_ ? azimuths_ / 4 : azimuths_ - 1;
  for (int q = 0; q <= last; ++q) {
    const Direction wi = -leaving(!way.from_above, mu_in, q);
    for (int p = 0; p < azimuths_; ++p) f(p, q) = f_(wi, leaving(way.to_above, mu_out, p));
  }
  for (int q = last + 1; q < azimuths_; ++q) {
    // Turned over about the y axis, or about the x axis.
    const bool about_y = q <= half;
    const int from = about_y ? half - q : azimuths_ - q;
    for (int p = 0; p < azimuths_; ++p)
      f(p, q) = f(((about_y ? half : 0) - p + 2 * azimuths_) % azimuths_, from);
  }
  return f;
}

void AnisotropicBoundary::make_operators() {
  const Index waves = waves_.cols();
  const MatrixXd back = waves_.transpose() / azimuths_;
  for (const Way way : ways()) {
    const DirectionSets &from = set(way.from_above), &to = set(way.to_above);
    MatrixXd& all =
        operators_.emplace_back(MatrixXd::Zero(waves * to.nodes(), waves * from.nodes()));
    tbb::parallel_for(Index{0}, from.nodes(), [&](Index j) {
      const Between fine = between(to, kFiner, upright(way, from, to, from.in[j]));
      for (Index k = 0; k < fine.mu.size(); ++k) {
        const MatrixXd at =
            product_(product_(back, values(way, from.in[j], fine.mu[k])), waves_ / azimuths_);
        for (Index i = 0; i < to.nodes(); ++i)
          if (const double share = fine.of_nodes(k, i) * fine.flux[k] / to.flux[i]; share != 0)
            all.block(i * waves, j * waves, waves, waves) += share * at;
      }
    });
  }
  if (!absorbed_) return;
  absorbed_waves_.resize(above_->nodes(), waves);
  if (is_open_) {
    absorbed_waves_.setZero();
    return;
  }
  tbb::parallel_for(Index{0}, above_->nodes(), [&](Index j) {
    VectorXd shares(azimuths_);
    for (int q = 0; q < azimuths_; ++q) shares[q] = absorbed_(-leaving(false, above_->in[j], q));
    absorbed_waves_.row(j) = (back * shares).transpose();
  });
}

FaceLight AnisotropicBoundary::from(const FaceLight& arriving) const {
  const Index waves = waves_.cols(), columns = arriving.down.cols();
  FaceLight leaving{is_open_ ? MatrixXd::Zero(below_->out.size(), columns) : MatrixXd(),
                    MatrixXd::Zero(above_->out.size(), columns)};
  const std::vector<Way> all = ways();
  for (std::size_t k = 0; k < all.size(); ++k) {
    const Way way = all[k];
    const DirectionSets &from = set(way.from_above), &to = set(way.to_above);
    const MatrixXd& light = way.from_above ? arriving.down : arriving.up;
    if (light.size() == 0) continue;
    const MatrixXd irradiance =
        (from.flux.asDiagonal() * light.topLeftCorner(from.nodes(), waves)).transpose();
    const VectorXd answer =
        operators_[k] * Map<const VectorXd>(irradiance.data(), irradiance.size());
    (way.to_above ? leaving.up : leaving.down).topLeftCorner(to.nodes(), waves) +=
        Map<const MatrixXd>(answer.data(), waves, to.nodes()).transpose();
  }
  return leaving;
}

void AnisotropicBoundary::add_asked(const std::vector<FaceLight>& arriving,
                                    std::vector<FaceLight>& leaving) const {
  const Index waves = waves_.cols(), count = static_cast<Index>(arriving.size());
  for (const Way way : ways()) {
    const DirectionSets &from = set(way.from_above), &to = set(way.to_above);
    const Index asked = to.out.size() - to.nodes();
    tbb::parallel_for(Index{0}, asked, [&](Index i) {
      if (!exists(to.out_exists, i)) return;
      const double mu = to.out[to.nodes() + i];
      const Between fine = between(from, kFiner, upright(way, to, from, mu));
      // Irradiance at the azimuths: rows; by cosine and entry.
      std::vector<MatrixXd> light(static_cast<std::size_t>(fine.mu.size()),
                                  MatrixXd::Zero(azimuths_, count));
      for (Index k = 0; k < count; ++k) {
        const MatrixXd& in = way.from_above ? arriving[k].down : arriving[k].up;
        if (in.size() == 0) continue;
        const MatrixXd at = product_(product_(fine.of_nodes, in.topLeftCorner(from.nodes(), waves)),
                                     waves_.transpose());
        for (Index j = 0; j < fine.mu.size(); ++j)
          light[j].col(k) = fine.flux[j] / azimuths_ * at.row(j).transpose();
      }
      MatrixXd sum = MatrixXd::Zero(azimuths_, count);
      for (Index j = 0; j < fine.mu.size(); ++j)
        if (!light[j].isZero(0)) sum += values(way, fine.mu[j], mu) * light[j];
      const MatrixXd in_waves = waves_.transpose() * sum / azimuths_;
      for (Index k = 0; k < count; ++k) {
        MatrixXd& out = way.to_above ? leaving[k].up : leaving[k].down;
        out.row(to.nodes() + i).head(waves) += in_waves.col(k).transpose();
      }
    });
  }
}

FaceLight AnisotropicBoundary::from_beam(double azimuth, Index in, double down, double up,
                                         Index columns) const {
  const Index waves = waves_.cols();
  FaceLight leaving{is_open_ ? MatrixXd::Zero(below_->out.size(), columns) : MatrixXd(),
                    MatrixXd::Zero(above_->out.size(), columns)};
  for (const Way way : ways()) {
    const double power = way.from_above ? down : up;
    const DirectionSets &from = set(way.from_above), &to = set(way.to_above);
    if (!(power > 0) || !exists(from.in_exists, in)) continue;
    const double mu = from.in[from.nodes() + in];
    const Direction wi = -direction_from_mu_phi(way.from_above ? -mu : mu, azimuth);
    MatrixXd& out = way.to_above ? leaving.up : leaving.down;
    // More azimuths than waves need, since nothing has smoothed the lobe.
    const int count = kFinest * azimuths_;
    const MatrixXd back = power / count * azimuthal_waves(waves, even_azimuths(count)).transpose();
    const auto lobe = [&](double cosine) {
      VectorXd f(count);
      for (int p = 0; p < count; ++p)
        f[p] = f_(wi, direction_from_mu_phi(way.to_above ? cosine : -cosine, 2 * kPi * p / count));
      return VectorXd(back * f);
    };
    const Between fine = between(to, kFinest, upright(way, from, to, mu));
    MatrixXd between_nodes(fine.mu.size(), waves);
    tbb::parallel_for(Index{0}, fine.mu.size(), [&](Index k) {
      between_nodes.row(k) = fine.flux[k] * lobe(fine.mu[k]).transpose();
    });
    out.topLeftCorner(to.nodes(), waves) +=
        to.flux.cwiseInverse().asDiagonal() * (fine.of_nodes.transpose() * between_nodes);
    if (is_open_) continue;
    tbb::parallel_for(to.nodes(), to.out.size(), [&](Index i) {
      if (exists(to.out_exists, i - to.nodes()))
        out.row(i).head(waves) += lobe(to.out[i]).transpose();
    });
  }
  return leaving;
}

AnisotropicBoundary::Taken AnisotropicBoundary::taken(const FaceLight& arriving) const {
  const FaceLight light = from(arriving);
  double rest = above_->flux.dot(arriving.down.col(0).head(above_->nodes())) -
                above_->flux.dot(light.up.col(0).head(above_->nodes()));
  if (is_open_) {
    if (arriving.up.size() > 0) rest += below_->flux.dot(arriving.up.col(0).head(below_->nodes()));
    rest -= below_->flux.dot(light.down.col(0).head(below_->nodes()));
  }
  if (!absorbed_) return {rest, 0};
  const Index nodes = above_->nodes();
  const double absorbed =
      (above_->flux.asDiagonal() * arriving.down.topLeftCorner(nodes, waves_.cols()))
          .cwiseProduct(absorbed_waves_)
          .sum();
  return {absorbed, rest - absorbed};
}

AnisotropicBoundary::Taken AnisotropicBoundary::taken_of_beam(double azimuth, Index in, double down,
                                                              double up) const {
  const FaceLight light = from_beam(azimuth, in, down, up, waves_.cols());
  double rest = down + up - above_->flux.dot(light.up.col(0).head(above_->nodes()));
  if (is_open_) rest -= below_->flux.dot(light.down.col(0).head(below_->nodes()));
  if (!absorbed_) return {rest, 0};
  const double mu = above_->in[above_->nodes() + in];
  const double absorbed =
      is_open_ || !(down > 0) ? 0 : down * absorbed_(-direction_from_mu_phi(-mu, azimuth));
  return {absorbed, rest - absorbed};
}

}  // namespace lamella
