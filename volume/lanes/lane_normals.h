#pragma once

// Number types: tables of float, made in double. Domain: kappa in [0, 1e8], any direction w.
// Error: cumulative probabilities within kNormalError of the distribution's own.
//
// Visible normals of vMF flakes, density D(m) <w, m> / sigma(w), from two uniform numbers and
// without rejection. With the mean normal a, u = w.a, s = sqrt(1 - u^2), T the unit vector along
// w - u a and B = a x T, a normal is
//
//   m = cos(g) (cos(b) a + sin(b) T) + sin(g) B,   w.m = cos(g) sin(d),   d = b + arcsin(u).
//
// What faces w has d in (0, pi) whatever g is, so that the density factors into
//
//   p(b) ~ sin(d) F(kappa cos(b)),   p(g | b) ~ cos(g)^2 exp(c cos(g)), c = kappa cos(b),
//   F(c): the integral of cos(g)^2 exp(c cos(g)) over (-pi/2, pi/2).
//
// Both are tabulated as quantiles: E is the exponential number of the probability beyond them.

#include <vector>

namespace lamella {

/// A bicubic patch: sixteen coefficients, those of powers of the column's place within the rows'.
struct alignas(64) NormalPatch {
  float power[4][4];
};

/// Patches of a sheet by its row and column, and the bound of the error named above.
inline constexpr int kNormalRows = 24, kNormalColumns = 16, kSideRows = 16, kSideColumns = 32;
inline constexpr double kNormalError = 2e-5;
/// Columns are those of sqrt(E + kColumnStart) - sqrt(kColumnStart), which is smooth at 0 and grows
/// like the quantiles of narrow distributions.
inline constexpr double kColumnStart = 0.5;
/// Beyond this q, in units of k, sigma is below 1e-30 from behind.
inline constexpr double kLargestBehind = 6;

/// Sheets of a kappa: d in units of half turns times kappa |u| + sqrt(kappa + 1) where u < 0, then
/// b in half turns times the latter's root where u >= 0; of each the probability below, and above,
/// is exp(-E) / 2. Rows, with k = 1 / sqrt(kappa + 1): q = |u| / (1 + s) over
/// min(1, kLargestBehind k) from behind, u / (u + 2 k s) from the front.
[[nodiscard]] std::vector<NormalPatch> vmf_normal_sheets(double kappa);
/// From this c on |g| is a polynomial: with x = c - kLeastFront, |g| sqrt(x + kFrontScale) in half
/// turns, the probability beyond it exp(-E), in powers of 2 x / (x + kFrontPlace) - 1 (rows) and of
/// twice the column's place less 1.
inline constexpr double kLeastFront = -1.5, kFrontScale = 3, kFrontPlace = 6;
inline constexpr int kFrontRows = 10, kFrontColumns = 14;
/// The polynomial's coefficients, rows of columns, and a sheet for smaller c: (pi/2 - |g|)
/// (|c| + 2) in half turns, the probability of smaller |g| exp(-E). Rows: |c| / (|c| + 4); columns:
/// the cube root of E / kLargestExponential. Tables begin with them.
[[nodiscard]] const std::vector<NormalPatch>& side_sheets();
inline constexpr unsigned kSidePatch = (kFrontRows * kFrontColumns + 15) / 16;

/// -log of the projected area at -|u|, at most 100, in kSigmaPieces cubics of q over
/// min(1, kLargestBehind k), four of them in a NormalPatch.
inline constexpr int kSigmaPieces = 64;
[[nodiscard]] std::vector<NormalPatch> back_sigma_pieces(double kappa, double alpha);

}  // namespace lamella
