#include "phase/lanes/isa.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <stdexcept>

namespace lamella {
namespace {

constexpr const char* kNames[] = {"scalar", "sse4", "avx2", "avx512"};

// What lamella_lanes() in the top CMakeLists.txt lets the compiler use, no less.
bool machine_runs(Isa isa) {
  __builtin_cpu_init();
#define LAMELLA_HAS(feature) (__builtin_cpu_supports(feature) != 0)
  const bool sse4 =
      LAMELLA_HAS("sse4.2") && LAMELLA_HAS("popcnt") && LAMELLA_HAS("aes") && LAMELLA_HAS("pclmul");
  const bool avx2 = sse4 && LAMELLA_HAS("avx2") && LAMELLA_HAS("fma") && LAMELLA_HAS("bmi") &&
                    LAMELLA_HAS("bmi2");
  const bool avx512 = avx2 && LAMELLA_HAS("avx512f") && LAMELLA_HAS("avx512bw") &&
                      LAMELLA_HAS("avx512dq") && LAMELLA_HAS("avx512cd") && LAMELLA_HAS("avx512vl");
#undef LAMELLA_HAS
  switch (isa) {
    case Isa::sse4:
      return sse4;
    case Isa::avx2:
      return avx2;
    case Isa::avx512:
      return avx512;
    default:
      return true;
  }
}

bool is_compiled(Isa isa) {
#ifdef LAMELLA_WITHOUT_SSE4
  if (isa == Isa::sse4) return false;
#endif
#ifdef LAMELLA_WITHOUT_AVX2
  if (isa == Isa::avx2) return false;
#endif
#ifdef LAMELLA_WITHOUT_AVX512
  if (isa == Isa::avx512) return false;
#endif
  static_cast<void>(isa);
  return true;
}

Isa named(std::string_view text, const char* where) {
  for (const Isa isa : {Isa::scalar, Isa::sse4, Isa::avx2, Isa::avx512}) {
    if (text != kNames[static_cast<int>(isa)]) continue;
    if (is_supported(isa)) return isa;
    std::string allowed = "auto";
    for (const Isa other : supported_isas()) allowed += ", " + to_text(other);
    throw std::invalid_argument(
        fmt::format("{}: found \"{}\", which {} lacks; allowed here: {}", where, text,
                    is_compiled(isa) ? "this machine" : "this build", allowed));
  }
  throw std::invalid_argument(
      fmt::format("{}: found \"{}\"; allowed: auto, scalar, sse4, avx2, avx512", where, text));
}

}  // namespace

std::string to_text(Isa isa) { return kNames[static_cast<int>(isa)]; }

const std::vector<Isa>& supported_isas() {
  static const std::vector<Isa> list = [] {
    std::vector<Isa> found;
    for (const Isa isa : {Isa::scalar, Isa::sse4, Isa::avx2, Isa::avx512})
      if (is_compiled(isa) && machine_runs(isa)) found.push_back(isa);
    return found;
  }();
  return list;
}

bool is_supported(Isa isa) {
  return std::find(supported_isas().begin(), supported_isas().end(), isa) != supported_isas().end();
}

Isa isa_from_text(std::string_view text) {
  if (text != "auto") return named(text, "--isa");
  const char* variable = std::getenv("LAMELLA_ISA");
  if (variable && *variable && std::string_view(variable) != "auto")
    return named(variable, "LAMELLA_ISA");
  return supported_isas().back();
}

}  // namespace lamella
