#pragma once

#include "phase/stack/stack.h"

namespace lamella {

/// The stack with a substrate that reflects by a closed form (`bsdf = "eon"`), its parameters
/// checked and completed, its law ready for walks. Other stacks come back as they are. Throws
/// StackFileError, which names the substrate's place, the value found and the values allowed.
[[nodiscard]] Stack with_surface_model(Stack stack);

}  // namespace lamella
