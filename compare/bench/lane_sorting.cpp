#include "compare/bench/lane_sorting.h"

#include "phase/random/lane_random.h"

namespace lamella::LAMELLA_ISA {
namespace {

constexpr int kLanes = Words::kCount, kSets = 4, kWalks = kSets * kLanes;
constexpr int kNumbers = 12;

struct Walks {
  alignas(64) std::uint32_t number[kNumbers][kWalks + kLanes];
};

}  // namespace

int sorted_walks() { return kWalks; }

std::uint32_t sort_walks(std::uint32_t steps) {
  static thread_local Walks buffers[2];
  WalkNumbers<Words> draws;
  for (std::uint32_t k = 0; k < 4; ++k) draws.s[k] = Words::iota() + Words(17u * k + 1u);
  for (std::uint32_t step = 0; step < steps; ++step) {
    const Walks& from = buffers[step & 1u];
    Walks& to = buffers[1 - (step & 1u)];
    WordMask first[kSets];
    int counts[kSets];
    for (int k = 0; k < kSets; ++k) {
      first[k] = is_below(shift_right<1>(draws.next()), Words(0x40000000u));
      counts[k] = count(first[k]);
    }
    for (int n = 0; n < kNumbers; ++n) {
      std::uint32_t* at = to.number[n];
      for (int k = 0; k < kSets; ++k) {
        store_compressed(Words::load(from.number[n] + k * kLanes), first[k], at);
        at += counts[k];
      }
      for (int k = 0; k < kSets; ++k) {
        store_compressed(Words::load(from.number[n] + k * kLanes), !first[k], at);
        at += kLanes - counts[k];
      }
    }
  }
  std::uint32_t sum = 0;
  for (const auto& number : buffers[steps & 1u].number) sum += number[0];
  return sum;
}

}  // namespace lamella::LAMELLA_ISA
