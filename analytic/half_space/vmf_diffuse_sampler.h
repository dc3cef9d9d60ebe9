#pragma once

#include "analytic/model/clipped_cosine.h"

namespace lamella {

/// The lobe from which VMF Diffuse draws w_i given w_o, whose cosine is mu in [0, 1]; roughness r
/// in [0, 1]. Bilinear in sqrt(r) and sqrt(mu) between the nodes of a table that `lamella fit
/// --sampling vmf_diffuse` printed: the clipped cosine of EON (Portsmouth, Kutz and Hill 2025,
/// section 4.1, suggest it) with the least variance for white flakes. Any values between the nodes
/// make a valid density. `lamella samplers` shows the variance with it.
[[nodiscard]] ClippedCosine vmf_diffuse_sampling_lobe(double mu, double roughness);

}  // namespace lamella
