#pragma once

#include <span>
#include <vector>

#include "phase/math/color.h"

namespace lamella {

// The error that a viewer sees who flips between two pictures. Andersson et al. 2020, "FLIP: A
// Difference Evaluator for Alternating Images", for pictures of a display (LDR-FLIP).

/// Of a monitor of 3840 pixels over 0.7 m that is seen from 0.7 m, as in the paper.
inline constexpr double kFlipPixelsPerDegree = 67.0206432765;

/// The error per pixel, in [0, 1]: 0 where both are equal in the eye's surroundings of the pixel.
/// Both pictures: width x height colours row by row, linear sRGB, cut to [0, 1]; beyond their edges
/// the outermost pixels go on. Colours are blurred as the eye's contrast sensitivity has it and
/// compared in CIELAB with Hunt's adjustment; differences of edges and points raise the error.
[[nodiscard]] std::vector<double> flip_errors(int width, int height, std::span<const Rgb> reference,
                                              std::span<const Rgb> test,
                                              double pixels_per_degree = kFlipPixelsPerDegree);

}  // namespace lamella
