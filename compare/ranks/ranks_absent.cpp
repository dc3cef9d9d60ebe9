#include <fmt/format.h>

#include <cstdlib>

#include "compare/ranks/ranks.h"
#include "compare/request/errors.h"
#include "compare/request/numbers.h"

namespace lamella {

Ranks* started_ranks() {
  const char* const size = std::getenv("OMPI_COMM_WORLD_SIZE");
  const auto count = size ? parse_whole_number(size) : std::nullopt;
  if (count && *count > 1)
    throw UsageError(
        fmt::format("mpirun: found {} processes, and this build has no MPI: each would do all of "
                    "the work; allowed: one process, --shard I/N, or a build with -DLAMELLA_MPI=ON",
                    *count));
  return nullptr;
}

void finish_ranks() {}

}  // namespace lamella
