// Stands in for least_squares.cpp, bounded_least_squares.cpp and sampler_fit.cpp where there is no
// Ceres.
#include "compare/fit/bounded_least_squares.h"
#include "compare/fit/least_squares.h"
#include "compare/fit/sampler_fit.h"

namespace lamella {
namespace {

[[noreturn]] void refuse() {
  throw FitError(
      "fits need Ceres, and this lamella was built without (-DLAMELLA_CERES=OFF); allowed: models "
      "with their parameters given, or a build with libceres-dev and -DLAMELLA_CERES=ON");
}

}  // namespace

bool has_least_squares() { return false; }
void require_least_squares() { refuse(); }

SamplingLobeTable fit_sampling_lobes(const std::function<std::unique_ptr<Model>(double)>&, int,
                                     int) {
  refuse();
}

UnitMinimum minimum_from(const UnitProblem&, std::vector<double>, const UnitEffort&) { refuse(); }

std::string to_initializers(const SamplingLobeTable&) { refuse(); }

}  // namespace lamella
