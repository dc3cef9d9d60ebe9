#include "analytic/spongecake_network/spongecake_network.h"

// The assembler takes a file in as it is, between the symbols NAME_begin and NAME_end.
// LAMELLA_SPONGECAKE_1 and _2 are the paths that the build gives.
#define LAMELLA_TAKE_IN(name, path) \
  asm(".section .rodata\n"          \
      ".globl " name                \
      "_begin\n"                    \
      ".globl " name "_end\n" name  \
      "_begin:\n"                   \
      ".incbin \"" path "\"\n" name \
      "_end:\n"                     \
      ".byte 0\n"                   \
      ".previous\n")

LAMELLA_TAKE_IN("lamella_spongecake_1", LAMELLA_SPONGECAKE_1);
LAMELLA_TAKE_IN("lamella_spongecake_2", LAMELLA_SPONGECAKE_2);

extern "C" const char lamella_spongecake_1_begin[], lamella_spongecake_1_end[],
    lamella_spongecake_2_begin[], lamella_spongecake_2_end[];

namespace lamella {

std::string_view spongecake_weights(int layers) {
  const auto between = [](const char* begin, const char* end) {
    return std::string_view(begin, static_cast<std::size_t>(end - begin));
  };
  return layers == 1 ? between(lamella_spongecake_1_begin, lamella_spongecake_1_end)
                     : between(lamella_spongecake_2_begin, lamella_spongecake_2_end);
}

}  // namespace lamella
