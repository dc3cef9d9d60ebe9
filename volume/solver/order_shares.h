#pragma once

#include <array>

namespace lamella {

/// Shares of a beam by the number of events that it has met: 0, 1, 2, 3, and 4 or more. A product
/// is what two stretches of the way leave together; their numbers of events add up. Nothing is
/// found as a difference.
struct OrderShares {
  static constexpr int kSize = 5, kLast = kSize - 1;

  std::array<double, kSize> of{};

  [[nodiscard]] double sum() const {
    double all = 0;
    for (const double x : of) all += x;
    return all;
  }
  friend OrderShares operator+(OrderShares a, const OrderShares& b) {
    for (int k = 0; k < kSize; ++k) a.of[k] += b.of[k];
    return a;
  }
  friend OrderShares operator+(double a, OrderShares b) {
    b.of[0] += a;
    return b;
  }
  friend OrderShares operator*(double a, OrderShares b) {
    for (double& x : b.of) x *= a;
    return b;
  }
  friend OrderShares operator*(const OrderShares& a, const OrderShares& b) {
    OrderShares product;
    for (int i = 0; i < kSize; ++i)
      for (int j = 0; j < kSize; ++j)
        product.of[i + j < kLast ? i + j : kLast] += a.of[i] * b.of[j];
    return product;
  }
};

/// x / (1 - a): what comes of x with all rounds of the share a.
[[nodiscard]] inline double with_rounds(double x, double a) { return x / (1 - a); }
[[nodiscard]] inline OrderShares with_rounds(const OrderShares& x, const OrderShares& a) {
  constexpr int kLast = OrderShares::kLast;
  OrderShares rounds;  // y = 1 + a y
  for (int k = 0; k < kLast; ++k) {
    double before = k == 0 ? 1 : 0;
    for (int i = 1; i <= k; ++i) before += a.of[i] * rounds.of[k - i];
    rounds.of[k] = before / (1 - a.of[0]);
  }
  double more = 0;
  for (int j = 0; j < kLast; ++j)
    for (int i = kLast - j; i <= kLast; ++i) more += a.of[i] * rounds.of[j];
  rounds.of[kLast] = more / (1 - a.sum());
  return x * rounds;
}

}  // namespace lamella
