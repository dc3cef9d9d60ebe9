#pragma once

#include <vector>

#include "phase/stack/stack.h"

namespace lamella {

/// Cosines, at the stack's top (`above`) or bottom, of the directions that a smooth interface
/// anywhere in the stack meets at its critical angle. There f behaves like the root of the distance
/// to them on one side. Ascending, each once; empty where no index in the stack is lower than that
/// outside.
[[nodiscard]] std::vector<double> critical_cosines(const Stack& stack, bool above);

/// The cosine (positive) at which light that arrives with the cosine mu, from above where mu > 0,
/// leaves the other side by refraction alone; 0 where it is totally reflected there.
[[nodiscard]] double bent_through(const Stack& stack, double mu);

}  // namespace lamella
