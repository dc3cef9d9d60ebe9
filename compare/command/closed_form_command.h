#pragma once

#include "compare/options/options.h"

namespace lamella {

/// Options of the commands about closed forms, beside those that all commands share.
struct ClosedFormOptions {
  std::vector<std::string> outgoing{};  ///< theta_o in degrees
  std::uint64_t samples = 100000;
  std::string sampling{};  ///< the model whose sampling lobes are fitted
  bool bond = false;       ///< light from everywhere instead of --wi
};

/// Variance and largest weight of models' samplers.
int samplers_command(const Options& options, const ClosedFormOptions& closed);
/// SpongeCake's further lobes for a stack, or a model's sampling lobes.
int fit_command(const Options& options, const ClosedFormOptions& closed);
/// The albedo that gives a colour. `words`: a model or stack and its key=value arguments, color
/// among them.
int invert_command(const Options& options, const ClosedFormOptions& closed,
                   const std::vector<std::string>& words);
/// The white furnace of models over the whole range of their parameters.
int furnace_sweep_command(const Options& options);

}  // namespace lamella
