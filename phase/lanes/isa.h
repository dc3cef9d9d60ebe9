#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace lamella {

/// Instruction sets that kernels are compiled for. `scalar` is the double reference, which any
/// x86-64 runs; the others work on lanes (phase/lanes/lanes.h): 4, 8 and 16 floats.
enum class Isa { scalar, sse4, avx2, avx512 };

[[nodiscard]] std::string to_text(Isa isa);

/// What this machine (and its operating system) can run of what was compiled (LAMELLA_ISAS), the
/// narrowest first; scalar always.
[[nodiscard]] const std::vector<Isa>& supported_isas();
[[nodiscard]] bool is_supported(Isa isa);

/// "auto" is the widest that is supported, unless the environment variable LAMELLA_ISA names one;
/// any other text is the name of one. Throws std::invalid_argument, its text a line for the user,
/// for a name that does not exist or a set that the machine lacks.
[[nodiscard]] Isa isa_from_text(std::string_view text);

// Sets that LAMELLA_ISAS leaves out have no functions.
#ifdef LAMELLA_WITHOUT_SSE4
#define LAMELLA_FOR_SSE4(name) nullptr
#else
#define LAMELLA_FOR_SSE4(name) &isa_sse4::name
#endif
#ifdef LAMELLA_WITHOUT_AVX2
#define LAMELLA_FOR_AVX2(name) nullptr
#else
#define LAMELLA_FOR_AVX2(name) &isa_avx2::name
#endif
#ifdef LAMELLA_WITHOUT_AVX512
#define LAMELLA_FOR_AVX512(name) nullptr
#else
#define LAMELLA_FOR_AVX512(name) &isa_avx512::name
#endif

/// Declares a function that a source of lamella_lanes() defines in each set's namespace, and in
/// namespace lamella a pointer to the one of a set: LAMELLA_LANE_FUNCTION(void, f, (int n)) makes
/// `void (*f_for(Isa isa))(int n)`; null for Isa::scalar and for sets that were not compiled. Use
/// it inside namespace lamella.
// NOLINTBEGIN(bugprone-macro-parentheses): a list of parameters has its own
#define LAMELLA_LANE_FUNCTION(result, name, parameters)                 \
  namespace isa_sse4 {                                                  \
  result name parameters;                                               \
  }                                                                     \
  namespace isa_avx2 {                                                  \
  result name parameters;                                               \
  }                                                                     \
  namespace isa_avx512 {                                                \
  result name parameters;                                               \
  }                                                                     \
  [[nodiscard]] inline auto name##_for(Isa isa)->result(*) parameters { \
    using Pointer = result(*) parameters;                               \
    return isa == Isa::avx512 ? Pointer(LAMELLA_FOR_AVX512(name))       \
           : isa == Isa::avx2 ? Pointer(LAMELLA_FOR_AVX2(name))         \
           : isa == Isa::sse4 ? Pointer(LAMELLA_FOR_SSE4(name))         \
                              : nullptr;                                \
  }
// NOLINTEND(bugprone-macro-parentheses)

}  // namespace lamella
