#include "analytic/spongecake_network/spongecake_network.h"

// The assembler takes the file in as it is. LAMELLA_SPONGECAKE_1 is the path that the build gives.
asm(".section .rodata\n"
    ".globl lamella_spongecake_1_begin\n"
    ".globl lamella_spongecake_1_end\n"
    "lamella_spongecake_1_begin:\n"
    ".incbin \"" LAMELLA_SPONGECAKE_1
    "\"\n"
    "lamella_spongecake_1_end:\n"
    ".byte 0\n"
    ".previous\n");

extern "C" const char lamella_spongecake_1_begin[], lamella_spongecake_1_end[];

namespace lamella {

std::string_view spongecake_weights() {
  return {lamella_spongecake_1_begin,
          static_cast<std::size_t>(lamella_spongecake_1_end - lamella_spongecake_1_begin)};
}

}  // namespace lamella
