#pragma once

#include <vector>

#include "analytic/layered/spongecake.h"
#include "compare/request/interrupt.h"
#include "phase/stack/stack.h"

namespace lamella {

/// A cell of orders 2 and up of a stack, for a fit: one of those of equal projected solid angle.
struct LobeCell {
  Direction wi{};
  std::vector<Direction> wo{};  ///< nodes in mu^2 and phi, of equal weights
  Rgb truth{}, variance{};      ///< mean of f [1/sr] over the cell, and its variance
  bool reflected = true;
};

/// The nodes of a cell: row and column of a grid of mu_cells x phi_cells over one hemisphere, phi
/// relative to w_i. up: the upper hemisphere. Gauss's rule of two nodes per axis in each of
/// parts x parts parts of the cell.
[[nodiscard]] std::vector<Direction> cell_nodes(Direction wi, int row, int column, int mu_cells,
                                                int phi_cells, bool up, int parts = 1);
/// The parts that cells of 8 x 16 need: 2 with flakes of a roughness below 0.2, whose lobes are
/// narrower than a cell, else 1.
[[nodiscard]] int cell_parts(const Stack& stack);

/// The mean over a cell of two lobes; second: their spongecake_second_stack.
[[nodiscard]] Rgb value_of(const Stack& second, const SpongecakeLobes& lobes, const LobeCell& cell);

/// The two lobes that come nearest to the cells in the sum of squares over all channels, and the
/// search that found them.
struct TwoLobeFit {
  SpongecakeLobes lobes;
  double relative_rmse = 0;  ///< root of the sum of squared differences over that of the truth's
  int iterations = 0;
};

/// What is free: per layer the second lobe's roughness (or g) in [0.02, 0.999] (g: 0.98 at most)
/// and depth (a factor in [1e-3, 1e3]), and per channel its albedo and f0; the constant lobe per
/// side and channel. f is linear in the last three: with u = a f0 and v = a (1 - f0), a layer gives
/// u S + v q S, S its single scattering at f0 = 1 and q Schlick's weight. They are found by
/// nonnegative least squares at every step, for all channels from one factor, so that the search
/// (Levenberg and Marquardt's, from two starts) has but two numbers per layer: variable projection,
/// Golub and Pereyra 1973. Layers beyond the kSpongecakeLayers-th share that one's factors and keep
/// their f0. u and v are 10 / min(1, tau) at most, tau the second lobe's optical depth of the
/// layer; where light comes from above alone, that times exp(2 tau') below layers of depth tau'.
/// channels: 1 or 3. Throws std::invalid_argument where the truth is 0 everywhere. `stop`, once
/// set, ends the search at the next step.
[[nodiscard]] TwoLobeFit fit_two_lobes(const Stack& stack, const std::vector<LobeCell>& cells,
                                       int channels, const StopFlag* stop = nullptr);

}  // namespace lamella
