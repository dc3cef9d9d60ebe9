#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "compare/ensemble/spongecake_accuracy.h"
#include "compare/reproduce/lobe_matrix.h"

namespace lamella {

/// The grid of the matrices of SpongeCake's lobes.
inline constexpr CellGrid kMatrixGrid{8, 16, false};

/// Orders 2 and up of a stack along the incident directions of a lobe matrix (matrix_directions of
/// kMatrixGrid), `walks` along each of these. One task per direction. Once `stop` is set: nothing.
[[nodiscard]] MultipleLobes matrix_truth(const Stack& stack, std::uint64_t walks,
                                         std::uint64_t seed, const StopFlag* stop);

/// Every `step`-th of its directions; of kFitStep twelve, of other azimuths at every step of mu^2:
/// enough for a fit.
inline constexpr std::size_t kFitStep = 11;
[[nodiscard]] MultipleLobes thinned(const MultipleLobes& matrix, std::size_t step = kFitStep);

/// Luminances (Rec. 709) of values, plus those of `more`, which may be empty.
[[nodiscard]] std::vector<double> luminances(const std::vector<Rgb>& values,
                                             const std::vector<Rgb>& more);
[[nodiscard]] std::vector<double> minus(const std::vector<double>& a, const std::vector<double>& b);

/// Truth, network, best fit where there is one, and network minus truth side by side. trial: of a
/// matrix_truth. all_orders: with exact order 1, else orders 2 and up alone.
[[nodiscard]] LobeMatrix spongecake_matrix(const SpongecakeTrial& trial,
                                           const SpongecakeLobes& network,
                                           const std::optional<SpongecakeLobes>& fit,
                                           bool all_orders, const std::string& title);

}  // namespace lamella
