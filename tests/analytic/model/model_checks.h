#pragma once

#include <string>
#include <vector>

#include "analytic/model/model.h"

namespace lamella::testing {

/// How far a batch on lanes may be from single pairs in double, in units of the sizes of what a
/// value is summed from: its lobes, themselves differences of terms up to 1 / (pi mu), mu the
/// larger cosine. Measured: 3.1e-16.
inline constexpr double kLaneError = 6e-16;
[[nodiscard]] double lane_error(double lobes, Direction wi, Direction wo);

/// The model with these parameters, the others at their defaults, checked as the reader checks.
[[nodiscard]] std::unique_ptr<Model> make_model(
    const std::string& name, const std::vector<std::pair<std::string, ParameterValue>>& values);

/// Directions above the surface: mu = 1, several angles and azimuths, mu = 1e-7 and 0.
[[nodiscard]] std::vector<Direction> probe_directions();

/// Non-negative and finite values for every pair of probe_directions() but the one that grazes
/// twice, lobes that add up to eval, batches equal to eval, no transmission.
/// `negative`: the model's lobes may be negative. `lane_errors`: how many times lane_error a batch
/// may be off.
void expect_sane_values(const Model& model, int lobes, bool negative = false,
                        double lane_errors = 1);

/// |f(w_i, w_o) - f(w_o, w_i)| <= tolerance * f over probe_directions().
void expect_reciprocal(const Model& model, double tolerance = 1e-12);

/// The sampler against its density, and the density's integral, at normal, oblique and grazing
/// w_o.
void expect_sampler_follows_its_pdf(const std::string& name, const Model& model,
                                    double pdf_tolerance = 1e-7);

/// Model::albedo against the adaptive quadrature of f.
void expect_albedo_equals_quadrature(const Model& model, double tolerance = 1e-7);

}  // namespace lamella::testing
