#include "tests/phase/lanes/lane_probe.h"

#include "phase/lanes/double_lanes.h"
#include "phase/lanes/lane_erf.h"
#include "phase/lanes/lane_math.h"
#include "phase/random/lane_random.h"
#include "phase/random/lane_truncated.h"

namespace lamella::LAMELLA_ISA {

constexpr std::size_t kStep = Floats::kCount;

void probe_math(const float* x, float* log_x, float* exp_x, float* sine, float* cosine,
                std::size_t count) {
  for (std::size_t i = 0; i < count; i += kStep) {
    const Floats v = Floats::load(x + i);
    log(abs(v)).store(log_x + i);
    exp(v).store(exp_x + i);
    const auto [s, c] = sine_cosine_near_zero(v);
    s.store(sine + i);
    c.store(cosine + i);
  }
}

void probe_turns(const float* y, const float* x, float* turns, std::size_t count) {
  for (std::size_t i = 0; i < count; i += kStep)
    turns_of(Floats::load(y + i), Floats::load(x + i)).store(turns + i);
}

void probe_reciprocals(const float* x, float* inverse, float* inverse_root, float* cube_root,
                       std::size_t count) {
  for (std::size_t i = 0; i < count; i += kStep) {
    reciprocal(Floats::load(x + i)).store(inverse + i);
    reciprocal_sqrt(Floats::load(x + i)).store(inverse_root + i);
    cbrt(Floats::load(x + i)).store(cube_root + i);
  }
}

void probe_scaled_erfc(const float* x, float* value, std::size_t count) {
  for (std::size_t i = 0; i < count; i += kStep) scaled_erfc(Floats::load(x + i)).store(value + i);
}

void probe_double_math(const double* x, double* log_x, double* exp_x, double* cos_x, double* erf_x,
                       std::size_t count) {
  for (std::size_t i = 0; i < count; i += Doubles::kCount) {
    const Doubles v = Doubles::load(x + i);
    log(abs(v)).store(log_x + i);
    exp(v).store(exp_x + i);
    cos(v).store(cos_x + i);
    erf(v).store(erf_x + i);
  }
}

void probe_angles(const double* sine, const double* cosine, double* angle, std::size_t count) {
  for (std::size_t i = 0; i < count; i += Doubles::kCount)
    angle_of(Doubles::load(sine + i), Doubles::load(cosine + i)).store(angle + i);
}

void probe_philox(std::uint64_t seed, const std::uint32_t* c0, const std::uint32_t* c2,
                  std::uint32_t purpose, std::uint32_t* words, std::size_t count) {
  for (std::size_t i = 0; i < count; i += kStep) {
    const WordBlock block =
        philox(Words::load(c0 + i), Words(purpose), Words::load(c2 + i), Words(0u),
               static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32));
    for (std::size_t k = 0; k < 4; ++k) block.w[k].store(words + k * count + i);
  }
}

void probe_walk_numbers(const std::uint32_t* state, std::uint32_t* words, std::size_t count,
                        std::size_t draws) {
  for (std::size_t i = 0; i < count; i += kStep) {
    WordBlock block;
    for (std::size_t k = 0; k < 4; ++k) block.w[k] = Words::load(state + k * count + i);
    WalkNumbers<Words> numbers(block);
    for (std::size_t k = 0; k < draws; ++k) numbers.next().store(words + k * count + i);
  }
}

void probe_words(const std::uint32_t* words, float* uniform, float* signed_uniform, float* fine,
                 float* exponential, float* sine, float* cosine, std::size_t count) {
  for (std::size_t i = 0; i < count; i += kStep) {
    const Words bits = Words::load(words + i);
    uniform_of(bits).store(uniform + i);
    signed_uniform_of(bits).store(signed_uniform + i);
    fine_uniform_of(bits).store(fine + i);
    exponential_of(bits).store(exponential + i);
    const auto [s, c] = azimuth_of(bits);
    s.store(sine + i);
    c.store(cosine + i);
  }
}

void probe_truncated(const float* tau, const std::uint32_t* words, float* chance, float* length,
                     std::size_t count) {
  for (std::size_t i = 0; i < count; i += kStep) {
    const Floats collides = collision_chance(Floats::load(tau + i));
    collides.store(chance + i);
    truncated_exponential_of(collides, Words::load(words + i)).store(length + i);
  }
}

void probe_conditions(const std::uint32_t* a, const std::uint32_t* b, const float* x,
                      const float* limit, std::uint32_t* conditions, std::uint32_t* xors,
                      std::size_t count) {
  for (std::size_t i = 0; i < count; i += kStep) {
    const Words u = Words::load(a + i), v = Words::load(b + i);
    const WordMask below = is_below(u, v);
    const WordMask within = to_word_mask(is_within(Floats::load(x + i), Floats::load(limit + i)));
    (select(below, Words(1u), Words(0u)) | select(within, Words(2u), Words(0u)))
        .store(conditions + i);
    xor_of(u, v, Words(0x5A5A1234u)).store(xors + i);
  }
}

void probe_highest_bits(const std::uint32_t* a, std::uint32_t* places, std::uint32_t* words,
                        std::size_t count) {
  for (std::size_t i = 0; i < count; i += kStep) {
    const Words place = highest_bit(Words::load(a + i));
    place.store(places + i);
    word_with_bit(place).store(words + i);
  }
}

int probe_masks(const float* x, const std::uint32_t* masks, float* compressed, std::uint32_t* ranks,
                float* permuted, std::uint32_t* bits, std::size_t groups) {
  for (std::size_t g = 0; g < groups; ++g) {
    const std::size_t at = g * kStep;
    std::uint32_t chosen[kStep];
    for (std::size_t k = 0; k < kStep; ++k) chosen[k] = (masks[g] >> k) & 1;
    const FloatMask mask = to_float_mask(equal(Words::load(chosen), Words(1u)));
    const Floats v = Floats::load(x + at);
    store_compressed(v, mask, compressed + at);
    const Words rank = rank_of(mask);
    rank.store(ranks + at);
    permute(v, rank).store(permuted + at);
    bits[g] = mask_bits(mask);
  }
  return static_cast<int>(kStep);
}

}  // namespace lamella::LAMELLA_ISA
