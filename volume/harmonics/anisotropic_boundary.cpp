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

// Whether f is the same at -x and at -y, at some pairs that have nothing to do with each other.
bool is_mirrored_by_axes(const std::function<double(Direction wi, Direction wo)>& f) {
  constexpr int kPairs = 64;
  constexpr double kRounding = 1e-11;
  for (int n = 0; n < kPairs; ++n) {
    const auto share = [n](double step) { return std::fmod(0.5 + n * step, 1); };
    const Direction wi =
        direction_from_mu_phi(0.02 + 0.98 * share(0.7548776662), 2 * kPi * share(0.5698402910));
    const Direction wo =
        direction_from_mu_phi(0.02 + 0.98 * share(0.4301597090), 2 * kPi * share(0.3819660113));
    const double at = f(wi, wo);
    const double other = f({-wi.x, wi.y, wi.z}, {-wo.x, wo.y, wo.z});
    const double third = f({wi.x, -wi.y, wi.z}, {wo.x, -wo.y, wo.z});
    if (!(std::abs(at - other) + std::abs(at - third) <= kRounding * std::abs(at))) return false;
  }
  return true;
}

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
                                         const MatrixProduct& product,
                                         std::shared_ptr<const Operators> operators)
    : above_(&above),
      below_(&below),
      is_open_(true),
      azimuths_(azimuths_for(degree)),
      product_(product),
      waves_(azimuthal_waves(2 * degree + 1, even_azimuths(azimuths_))),
      operators_(std::move(operators)) {
  const Dielectric boundary{.facets = interface.facets,
                            .masking = interface.masking,
                            .multiple = false,
                            .above = above.index,
                            .below = below.index};
  f_ = [boundary](Direction wi, Direction wo) { return boundary.single(wi, wo); };
  absorbed_ = [](Direction) { return 0.0; };
  find_classes(degree);
  if (!operators_) make_operators();
  find_absorbed();
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
  has_axes_ = conductor || is_mirrored_by_axes(f_);
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
  find_classes(degree);
  make_operators();
  find_absorbed();
}

void AnisotropicBoundary::find_classes(int degree) {
  classes_.assign(has_axes_ ? 4 : 1, {});
  for (Index m = 0; m <= degree; ++m)
    for (const bool sine : {false, true})
      if (m > 0 || !sine)
        classes_[has_axes_ ? 2 * (m % 2) + (sine ? 1 : 0) : 0].push_back(
            sine ? 2 * m : std::max(Index{0}, 2 * m - 1));
  // Of one quadrant, whose ends stand for two azimuths and all between for four.
  const Index quarter = azimuths_ / 4, azimuths = has_axes_ ? quarter + 1 : azimuths_;
  const VectorXd phi = even_azimuths(azimuths_);
  cosines_ = phi.array().cos();
  sines_ = phi.array().sin();
  back_.resize(waves_.cols(), azimuths_);
  Index row = 0;
  for (const std::vector<Index>& waves : classes_) {
    MatrixXd& to = arriving_.emplace_back(azimuths, static_cast<Index>(waves.size()));
    for (std::size_t w = 0; w < waves.size(); ++w) {
      back_.row(row++) = waves_.col(waves[w]).transpose() / azimuths_;
      for (Index q = 0; q < azimuths; ++q) {
        const double copies = !has_axes_ ? 1 : q == 0 || q == quarter ? 2 : 4;
        to(q, static_cast<Index>(w)) = copies * waves_(q, waves[w]) / azimuths_;
      }
    }
  }
}

std::size_t AnisotropicBoundary::bytes() const {
  Index entries = 0;
  for (const auto& way : operators_->by_way)
    for (const Operators::OfClass& of_class : way)
      entries += of_class.nodes.size() + of_class.asked.size();
  return static_cast<std::size_t>(entries) * sizeof(double);
}

std::vector<AnisotropicBoundary::Way> AnisotropicBoundary::ways() const {
  if (!is_open_) return {{true, true}};
  return {{true, true}, {true, false}, {false, false}, {false, true}};
}

Direction AnisotropicBoundary::leaving(bool up, double mu, int p) const {
  const double sine = std::sqrt((1 - mu) * (1 + mu));
  return {sine * cosines_[p], sine * sines_[p], up ? mu : -mu};
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

std::vector<MatrixXd> AnisotropicBoundary::between_waves(Way way, double mu_in,
                                                         double mu_out) const {
  MatrixXd f(azimuths_, arriving_.front().rows());
  for (Index q = 0; q < f.cols(); ++q) {
    const Direction wi = -leaving(!way.from_above, mu_in, static_cast<int>(q));
    for (int p = 0; p < azimuths_; ++p) f(p, q) = f_(wi, leaving(way.to_above, mu_out, p));
  }
  const MatrixXd waves = product_(back_, f);
  std::vector<MatrixXd> by_class;
  Index row = 0;
  for (const MatrixXd& arriving : arriving_) {
    by_class.push_back(product_(waves.middleRows(row, arriving.cols()), arriving));
    row += arriving.cols();
  }
  return by_class;
}

void AnisotropicBoundary::make_operators() {
  auto all = std::make_shared<Operators>();
  for (const Way way : ways()) {
    std::vector<Operators::OfClass>& of_way = all->by_way.emplace_back(classes_.size());
    make_nodes(way, of_way);
    make_asked(way, of_way);
  }
  operators_ = std::move(all);
}

void AnisotropicBoundary::make_nodes(Way way, std::vector<Operators::OfClass>& all) const {
  const DirectionSets &from = set(way.from_above), &to = set(way.to_above);
  for (std::size_t c = 0; c < classes_.size(); ++c) {
    const Index waves = arriving_[c].cols();
    all[c].nodes = MatrixXd::Zero(waves * to.nodes(), waves * from.nodes());
  }
  tbb::parallel_for(Index{0}, from.nodes(), [&](Index j) {
    const Between fine = between(to, kFiner, upright(way, from, to, from.in[j]));
    for (Index k = 0; k < fine.mu.size(); ++k) {
      const std::vector<MatrixXd> at = between_waves(way, from.in[j], fine.mu[k]);
      for (Index i = 0; i < to.nodes(); ++i) {
        const double share = fine.of_nodes(k, i) * fine.flux[k] / to.flux[i];
        if (share == 0) continue;
        for (std::size_t c = 0; c < at.size(); ++c) {
          const Index waves = at[c].rows();
          all[c].nodes.block(i * waves, j * waves, waves, waves) += share * at[c];
        }
      }
    }
  });
}

void AnisotropicBoundary::make_asked(Way way, std::vector<Operators::OfClass>& all) const {
  const DirectionSets &from = set(way.from_above), &to = set(way.to_above);
  const Index asked = to.out.size() - to.nodes();
  for (std::size_t c = 0; c < classes_.size(); ++c) {
    const Index waves = arriving_[c].cols();
    all[c].asked = MatrixXd::Zero(waves * asked, waves * from.nodes());
  }
  tbb::parallel_for(Index{0}, asked, [&](Index i) {
    if (!exists(to.out_exists, i)) return;
    const double mu = to.out[to.nodes() + i];
    const Between fine = between(from, kFiner, upright(way, to, from, mu));
    for (Index k = 0; k < fine.mu.size(); ++k) {
      const std::vector<MatrixXd> at = between_waves(way, fine.mu[k], mu);
      for (Index j = 0; j < from.nodes(); ++j) {
        const double share = fine.of_nodes(k, j) * fine.flux[k] / from.flux[j];
        if (share == 0) continue;
        for (std::size_t c = 0; c < at.size(); ++c) {
          const Index waves = at[c].rows();
          all[c].asked.block(i * waves, j * waves, waves, waves) += share * at[c];
        }
      }
    }
  });
}

void AnisotropicBoundary::find_absorbed() {
  if (!absorbed_) return;
  absorbed_waves_ = MatrixXd::Zero(above_->nodes(), waves_.cols());
  if (is_open_) return;
  tbb::parallel_for(Index{0}, above_->nodes(), [&](Index j) {
    VectorXd shares(azimuths_);
    for (int q = 0; q < azimuths_; ++q) shares[q] = absorbed_(-leaving(false, above_->in[j], q));
    absorbed_waves_.row(j) = (waves_.transpose() * shares).transpose() / azimuths_;
  });
}

void AnisotropicBoundary::add(const MatrixXd& of_class, const std::vector<Index>& waves,
                              const MatrixXd& irradiance, Index first, MatrixXd& answer) const {
  const Index count = static_cast<Index>(waves.size());
  MatrixXd in(count, irradiance.rows());
  for (Index w = 0; w < count; ++w) in.row(w) = irradiance.col(waves[w]).transpose();
  const VectorXd out = of_class * Map<const VectorXd>(in.data(), in.size());
  for (Index w = 0; w < count; ++w)
    for (Index i = 0; i * count < out.size(); ++i)
      answer(first + i, waves[w]) += out[i * count + w];
}

FaceLight AnisotropicBoundary::from(const FaceLight& arriving) const {
  const Index waves = waves_.cols(), columns = arriving.down.cols();
  FaceLight leaving{is_open_ ? MatrixXd::Zero(below_->out.size(), columns) : MatrixXd(),
                    MatrixXd::Zero(above_->out.size(), columns)};
  const std::vector<Way> all = ways();
  for (std::size_t k = 0; k < all.size(); ++k) {
    const DirectionSets& from = set(all[k].from_above);
    const MatrixXd& light = all[k].from_above ? arriving.down : arriving.up;
    if (light.size() == 0) continue;
    const MatrixXd irradiance = from.flux.asDiagonal() * light.topLeftCorner(from.nodes(), waves);
    for (std::size_t c = 0; c < classes_.size(); ++c)
      add(operators_->by_way[k][c].nodes, classes_[c], irradiance, 0,
          all[k].to_above ? leaving.up : leaving.down);
  }
  return leaving;
}

void AnisotropicBoundary::add_asked(const std::vector<FaceLight>& arriving,
                                    std::vector<FaceLight>& leaving) const {
  const std::vector<Way> all = ways();
  tbb::parallel_for(std::size_t{0}, arriving.size(), [&](std::size_t n) {
    for (std::size_t k = 0; k < all.size(); ++k) {
      const DirectionSets &from = set(all[k].from_above), &to = set(all[k].to_above);
      const MatrixXd& light = all[k].from_above ? arriving[n].down : arriving[n].up;
      if (light.size() == 0) continue;
      const MatrixXd irradiance =
          from.flux.asDiagonal() * light.topLeftCorner(from.nodes(), waves_.cols());
      for (std::size_t c = 0; c < classes_.size(); ++c)
        add(operators_->by_way[k][c].asked, classes_[c], irradiance, to.nodes(),
            all[k].to_above ? leaving[n].up : leaving[n].down);
    }
  });
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
