#pragma once

#include <cstdint>
#include <span>

#include "phase/stack/stack.h"
#include "volume/result/thinning.h"

namespace lamella {

/// About how many events the longest walks have: the number of events after which the surviving
/// walks have fallen by a factor e, as absorption, the way out of a slab and the way out of
/// one-sided flakes end them. Of single media a test finds 0.25 to 1.8 times the estimate.
/// layers: those of the stack that have any depth (Plan::layers).
[[nodiscard]] double longest_walk(const Stack& stack, std::span<const int> layers);
/// Thinning with the first event that suits the stack's media, whether or not thinning saves time.
[[nodiscard]] Thinning thinning_of(const Stack& stack, std::span<const int> layers);
/// Thinning where the longest walks, which end after max_order events, are so long that thinning
/// saves time; else none.
[[nodiscard]] Thinning thinning_for(const Stack& stack, std::span<const int> layers,
                                    std::uint64_t max_order);

}  // namespace lamella
