#include "compare/report/page_template.h"

// The assembler takes the file in as it is: a string literal of its size is beyond what compilers
// promise. LAMELLA_PAGE is the path that the build gives.
asm(".section .rodata\n"
    ".globl lamella_page_begin\n"
    ".globl lamella_page_end\n"
    "lamella_page_begin:\n"
    ".incbin \"" LAMELLA_PAGE
    "\"\n"
    "lamella_page_end:\n"
    ".byte 0\n"
    ".previous\n");

extern "C" const char lamella_page_begin[], lamella_page_end[];

namespace lamella {

std::string_view page_template() {
  return {lamella_page_begin, static_cast<std::size_t>(lamella_page_end - lamella_page_begin)};
}

}  // namespace lamella
