#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "compare/request/truth_request.h"

namespace lamella {

/// Seconds that walks take in all, over the incident directions, where no number, time or error of
/// walks was asked for.
inline constexpr double kFirstLookSeconds = 20;

/// The rule that ends the runs of a request. Where no effort was asked for, the clock ends them,
/// too: narrow media of little absorption would take an hour for the default number of walks. The
/// number of walks is recorded, so that a rerun repeats them.
class FirstLook {
 public:
  /// `runs`: how many there will be; they share the time. A number of walks other than
  /// `default_walks` counts as asked for.
  FirstLook(const TruthRequest& request, std::size_t runs, double seconds = kFirstLookSeconds,
            std::uint64_t default_walks = StopRule{}.walks);

  /// Whether the clock may end runs that nobody gave a time.
  [[nodiscard]] bool has_clock() const { return has_clock_; }
  /// The effort of the next run. The runs to come share the time that the runs before them left.
  [[nodiscard]] StopRule next();

 private:
  using Clock = std::chrono::steady_clock;
  StopRule effort_;
  bool has_clock_;
  std::size_t left_;
  double seconds_;
  std::optional<Clock::time_point> start_{};
};

/// "theta_i 30: 4096 of 1000000 walks in 5 s; --walks or --time for more".
[[nodiscard]] std::string first_look_text(const std::string& label, std::uint64_t walks,
                                          const StopRule& rule);

}  // namespace lamella
