// What a prediction costs: time, and no memory.

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <vector>

#include "analytic/spongecake_network/spongecake_network.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define LAMELLA_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define LAMELLA_SANITIZED 1
#endif
#endif

namespace lamella {
namespace {

constinit thread_local std::size_t allocations = 0;

}  // namespace
}  // namespace lamella

// Eigen calls malloc and not operator new, which calls malloc in its turn: this counts both. A
// sanitizer has a malloc of its own.
#if defined(__GLIBC__) && !defined(LAMELLA_SANITIZED)
#define LAMELLA_COUNTS_ALLOCATIONS 1
extern "C" void* __libc_malloc(std::size_t size);
extern "C" void* malloc(std::size_t size) noexcept {
  ++lamella::allocations;
  return __libc_malloc(size);
}
#endif

namespace lamella {
namespace {

std::vector<NetworkLayer> some_layers(int count) {
  std::vector<NetworkLayer> layers(static_cast<std::size_t>(count));
  for (NetworkLayer& layer : layers) {
    layer.roughness = 0.4;
    layer.axis = {0.6, 0, 0.8};
    layer.depth = 1.5;
    layer.albedo = Rgb(0.9, 0.7, 0.5);
    layer.f0 = Rgb(0.3, 0.4, 0.5);
  }
  return layers;
}

TEST(SpongecakePrediction, AllocatesNothing) {
#ifndef LAMELLA_COUNTS_ALLOCATIONS
  GTEST_SKIP() << "allocations are counted with glibc's malloc alone";
#else
  for (const int count : {1, 2}) {
    const std::vector<NetworkLayer> layers = some_layers(count);
    const SpongecakeNetwork& network = spongecake_network(count);  // prepared
    const std::size_t before = allocations;
    double sum = 0;
    for (int n = 0; n < 100; ++n) sum += network.predict(layers).reflect.r;
    EXPECT_EQ(allocations, before);
    EXPECT_GT(sum, 0);
    // The count counts. What is volatile is not left out.
    double* volatile taken = new double[static_cast<std::size_t>(count)];
    delete[] taken;
    EXPECT_EQ(allocations, before + 1);
  }
#endif
}

TEST(SpongecakePrediction, TakesLessThanATenthOfAMillisecond) {
#ifdef LAMELLA_SANITIZED
  GTEST_SKIP() << "sanitizers take their time";
#endif
  using Clock = std::chrono::steady_clock;
  for (const int count : {1, 2}) {
    const std::vector<NetworkLayer> layers = some_layers(count);
    const SpongecakeNetwork& network = spongecake_network(count);
    double least = 1, sum = 0;
    // The quickest of many: the machine may have other work.
    for (int n = 0; n < 200; ++n) {
      const auto start = Clock::now();
      sum += network.predict(layers).reflect.r;
      least = std::min(least, std::chrono::duration<double>(Clock::now() - start).count());
    }
    EXPECT_GT(sum, 0);
    EXPECT_LT(least, 1e-4);
    RecordProperty("microseconds_" + std::to_string(count), std::to_string(1e6 * least));
  }
}

}  // namespace
}  // namespace lamella
