#include "volume/adding/modal_flights.h"

#include <cmath>

#include "volume/quadrature/depth_integrals.h"

namespace lamella {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

LayerDirections::LayerDirections(VectorXd cosines, VectorXd areas, double depth)
    : mu(std::move(cosines)), sigma(std::move(areas)) {
  direct = (-depth * sigma.cwiseQuotient(mu).array()).exp();
}

FlightTables::FlightTables(const LayerDirections& directions, const VectorXd& nu, double depth)
    : against(directions.mu.size(), nu.size()),
      along(directions.mu.size(), nu.size()),
      meet(directions.mu.size(), nu.size()) {
  for (Index k = 0; k < nu.size(); ++k)
    for (Index d = 0; d < directions.mu.size(); ++d) {
      const double mu = directions.mu[d], rate = directions.sigma[d] / mu;
      meet(d, k) = 1 / (mu + nu[k] * directions.sigma[d]);
      against(d, k) = -std::expm1(-(1 / nu[k] + rate) * depth) * meet(d, k);
      along(d, k) = crossing_integral(1 / nu[k], rate, depth) / nu[k] / mu;
    }
}

PairTables::PairTables(const LayerDirections& out, const LayerDirections& in, double depth)
    : back(out.mu.size(), in.mu.size()),
      on(out.mu.size(), in.mu.size()),
      apart(out.mu.size(), in.mu.size()) {
  constexpr double kNear = 0.02;
  for (Index i = 0; i < in.mu.size(); ++i)
    for (Index o = 0; o < out.mu.size(); ++o) {
      const double alpha = in.sigma[i] / in.mu[i], beta = out.sigma[o] / out.mu[o];
      const double sum = out.sigma[o] * in.mu[i] + in.sigma[i] * out.mu[o];
      const double difference = out.sigma[o] * in.mu[i] - in.sigma[i] * out.mu[o];
      back(o, i) = -std::expm1(-(alpha + beta) * depth) / sum;
      on(o, i) = crossing_integral(alpha, beta, depth) / in.mu[i] / out.mu[o];
      // Along grazing directions infinity times nothing is nothing.
      if (!std::isfinite(on(o, i))) on(o, i) = 0;
      apart(o, i) = std::abs(difference) > kNear * sum ? 1 / difference : 0;
      if (apart(o, i) == 0) near.push_back({o, i});
    }
}

Amplitudes::Amplitudes(const Eigen::Ref<const MatrixXd>& on, const Eigen::Ref<const MatrixXd>& back,
                       const LayerEigenmodes& modes, const DirectionSets& sets,
                       const MatrixProduct& product) {
  const VectorXd d = (2 * kPi * sets.weight).cwiseSqrt();
  const auto root = d.asDiagonal();
  const MatrixXd ahead = root * modes.forward, behind = root * modes.backward;
  forward = product(on, ahead);
  product.add(back, behind, forward);
  backward = product(back, ahead);
  product.add(on, behind, backward);
}

Amplitudes::Amplitudes(const Eigen::Ref<const MatrixXd>& on, const Eigen::Ref<const MatrixXd>& back,
                       const FreeFlights& flights)
    : forward(on * flights.excited.asDiagonal()), backward(back * flights.excited.asDiagonal()) {}

Lobes along_modes(const Amplitudes& out, const Amplitudes& in, const FlightTables& flights_out,
                  const FlightTables& flights_in, const LayerDirections& directions_out,
                  const LayerDirections& directions_in, const PairTables& pairs, const VectorXd& nu,
                  double depth, const MatrixProduct& product) {
  // Integrals over both events' depths, taken apart into products of a direction's own tables.
  const auto times = [&](const MatrixXd& a, const MatrixXd& b) -> MatrixXd {
    return product(a, b.transpose());
  };
  const auto mu_o = directions_out.mu.asDiagonal(), mu_i = directions_in.mu.asDiagonal();
  const MatrixXd out_meet = out.backward.cwiseProduct(flights_out.meet);
  const MatrixXd in_meet = in.backward.cwiseProduct(flights_in.meet);
  const MatrixXd out_along = out.forward.cwiseProduct(flights_out.along);
  const MatrixXd in_along = in.forward.cwiseProduct(flights_in.along);
  Lobes f;
  f.r = times(mu_o * out_meet, in.forward) + times(out.forward, mu_i * in_meet);
  f.r = f.r.cwiseProduct(pairs.back);
  if (!std::isinf(depth)) {
    f.r -= directions_out.direct.asDiagonal() * times(out_meet, in_along * nu.asDiagonal());
    f.r -= times(out_along * nu.asDiagonal(), in_meet) * directions_in.direct.asDiagonal();
    f.t = times(out.forward, mu_i * in_along) - times(mu_o * out_along, in.forward);
    f.t = f.t.cwiseProduct(pairs.apart);
    f.t += pairs.on.cwiseProduct(times(out.backward, mu_i * in_meet));
    f.t -= times(out.backward.cwiseProduct(flights_out.against) * nu.asDiagonal(), in_meet) *
           directions_in.direct.asDiagonal();
    for (const auto& [o, i] : pairs.near) {
      const double alpha = directions_in.sigma[i] / directions_in.mu[i];
      const double beta = directions_out.sigma[o] / directions_out.mu[o];
      double sum = 0;
      for (Index k = 0; k < nu.size(); ++k)
        sum += out.forward(o, k) * in.forward(i, k) / nu[k] *
               crossing_integral(alpha, beta, 1 / nu[k], depth);
      sum /= directions_in.mu[i] * directions_out.mu[o];
      if (std::isfinite(sum)) f.t(o, i) += sum;
    }
  } else {
    f.t = MatrixXd::Zero(out.forward.rows(), in.forward.rows());
  }
  return f;
}

}  // namespace lamella
