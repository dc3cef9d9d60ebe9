#include "compare/fit/least_squares.h"

namespace lamella {

bool has_least_squares() { return true; }
void require_least_squares() {}

}  // namespace lamella
