#include "analytic/spongecake_network/spongecake_network.h"

// The assembler takes the files in as they are. LAMELLA_SPONGECAKE_1 and _2 are the paths that the
// build gives.
asm(".section .rodata\n"
    ".globl lamella_spongecake_1_begin\n"
    ".globl lamella_spongecake_1_end\n"
    ".globl lamella_spongecake_2_begin\n"
    ".globl lamella_spongecake_2_end\n"
    "lamella_spongecake_1_begin:\n"
    ".incbin \"" LAMELLA_SPONGECAKE_1
    "\"\n"
    "lamella_spongecake_1_end:\n"
    "lamella_spongecake_2_begin:\n"
    ".incbin \"" LAMELLA_SPONGECAKE_2
    "\"\n"
    "lamella_spongecake_2_end:\n"
    ".byte 0\n"
    ".previous\n");

extern "C" const char lamella_spongecake_1_begin[], lamella_spongecake_1_end[],
    lamella_spongecake_2_begin[], lamella_spongecake_2_end[];

namespace lamella {

std::string_view spongecake_weights(int layers) {
  const char* begin = layers == 1 ? lamella_spongecake_1_begin : lamella_spongecake_2_begin;
  const char* end = layers == 1 ? lamella_spongecake_1_end : lamella_spongecake_2_end;
  return {begin, static_cast<std::size_t>(end - begin)};
}

}  // namespace lamella
