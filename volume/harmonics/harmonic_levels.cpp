#include "volume/harmonics/harmonic_levels.h"

#include <algorithm>
#include <cmath>

namespace lamella {
namespace {

constexpr double kSafety = 3;
constexpr double kLeastAhead = 0.1;

}  // namespace

HarmonicLevels::Change& HarmonicLevels::change(int channel, std::size_t i, bool up, int part) {
  const std::size_t directions = now_.answers[channel].size();
  return changes_[((channel * directions + i) * 2 + (up ? 0 : 1)) * kHarmonicParts + part];
}

const HarmonicLevels::Change& HarmonicLevels::change(int channel, std::size_t i, bool up,
                                                     int part) const {
  return const_cast<HarmonicLevels*>(this)->change(channel, i, up, part);
}

void HarmonicLevels::add(HarmonicLevel level) {
  before_ = std::move(now_);
  now_ = std::move(level);
  ++count_;
  const std::size_t channels = now_.answers.size(), directions = now_.answers.front().size();
  changes_.resize(channels * directions * 2 * kHarmonicParts);
  for (std::size_t c = 0; c < channels; ++c)
    for (std::size_t i = 0; i < directions; ++i)
      for (const bool up : {true, false})
        for (int part = 0; part < kHarmonicParts; ++part)
          if (!now_.answers[c][i].sides[up ? 0 : 1].value[part].empty())
            compare(static_cast<int>(c), i, up, part);
}

void HarmonicLevels::compare(int channel, std::size_t i, bool up, int part) {
  const HarmonicCells& cells = now_.answers[channel][i].sides[up ? 0 : 1];
  Change& change = this->change(channel, i, up, part);
  const double last = change.worst;
  change.worst = 0;
  change.of_row.assign(grid_.rows(), 0);
  for (int row = 0; row < grid_.rows(); ++row) {
    double sum = 0, square = 0, worst = 0;
    for (int column = 0; column < grid_.columns(); ++column) {
      const int cell = row * grid_.columns() + column;
      for (const int k : kSummedParts)
        if (!cells.value[k].empty()) sum += std::abs(cells.value[k][cell]);
      const double before = before_.answers.empty()
                                ? 0
                                : before_.answers[channel][i].sides[up ? 0 : 1].value[part][cell];
      const double difference = std::abs(cells.value[part][cell] - before);
      square += difference * difference;
      worst = std::max(worst, difference);
    }
    change.of_row[row] = std::sqrt(square / grid_.columns());
    if (sum > 0) change.worst = std::max(change.worst, worst / (sum / grid_.columns()));
  }
  // The first solution is no change.
  change.ahead =
      count_ > 2 && last > 0 ? std::clamp(kSafety * change.worst / last, kLeastAhead, 1.0) : 1;
}

double HarmonicLevels::error(int channel, std::size_t i, bool up, int cell, int part) const {
  const int side = up ? 0 : 1;
  const HarmonicCells& cells = now_.answers[channel][i].sides[side];
  if (cells.value[part].empty()) return 0;
  const double before =
      before_.answers.empty() ? 0 : before_.answers[channel][i].sides[side].value[part][cell];
  const Change& change = this->change(channel, i, up, part);
  return change.ahead * std::max(std::abs(cells.value[part][cell] - before),
                                 change.of_row[cell / grid_.columns()]) +
         cells.error[part][cell];
}

}  // namespace lamella
