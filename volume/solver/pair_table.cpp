#include "volume/solver/pair_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <unordered_set>
#include <vector>

#include "phase/math/direction.h"
#include "volume/solver/deterministic_channel.h"
#include "volume/solver/distinct_channels.h"

namespace lamella {
namespace {

// Chebyshev points of a panel. Light is an analytic function of the elevation but at grazing, where
// it varies like mu log mu. On a panel [a, 2 a] that point lies at -3 of [-1, 1], so that n points
// leave at most some (3 + sqrt(8))^-n of the variation: 8e-7 with eight; of mu log mu itself they
// leave 2e-8 to 2e-7.
constexpr int kPoints = 8;
// Fewer pairs are solved one by one. A pair takes 0.24 ms to 1e-4 and 0.65 ms to 1e-6, a first
// table as long as 140 and 290 of them (lamella bench --only solver --quick, Lambert spheres); a
// table that is refined three times has 22 times as many entries, as long as 3000 to 6000 pairs.
constexpr std::size_t kFewestPairs = 4096;
// Most refinements of a table: on half a panel eight points leave 3e-9 of what mu log mu varies, so
// that the second and third refinement are for the lowest panel and for thin slabs, and a fourth
// one would leave less than the solution's own bounds of 1e-9.
constexpr int kRefinements = 3;
// Of the first table: how often panels are halved towards grazing. The lowest panel ends at an
// elevation of 6e-3, in which mu log mu varies by 0.03; with the cube of the parameter its
// polynomials leave 7e-7 (9e-5 without). Each finer table has kMoreHalvings more (a lowest panel 16
// times narrower), and twice the parts of the panels above elevations of 90 / 2^3 degrees, which
// hold four fifths of the cosines.
constexpr int kHalvings = 8, kMoreHalvings = 4, kWidePanels = 3;
// What is left in a panel is like the polynomial T_8, which is below a quarter of its largest value
// on (2 / pi) asin(1 / 4), 16 %, of the parameter. All of the two or three tested cosines of a
// panel are there with a chance of 0.4 to 3 %.
constexpr double kSafety = 4;

// Chebyshev's points of [0, 1] and their barycentric weights.
struct Nodes {
  std::array<double, kPoints> t{}, weight{};
  Nodes() {
    for (int k = 0; k < kPoints; ++k) {
      const double angle = (2 * k + 1) * kPi / (2 * kPoints);
      t[k] = (1 - std::cos(angle)) / 2;
      weight[k] = (k % 2 == 0 ? 1 : -1) * std::sin(angle);
    }
  }
};
const Nodes& nodes() {
  static const Nodes list;
  return list;
}

// Where a cosine lies among those of the table: its first point and the weights of that and those
// that follow; `block`: of points that bounds are taken over.
struct Place {
  std::size_t first = 0, count = 0, block = 0;
  bool lowest = false;
  std::array<double, kPoints> weight{};
};

// The cosines of one side of the stack.
class Side {
 public:
  // few: absolute, sorted, distinct; none where they are many. refined: the table's, from 0.
  Side(const std::vector<double>& few, int refined) {
    edges_.push_back(0);
    for (int k = kHalvings + kMoreHalvings * refined; k > 0; --k) {
      const double low = kPi / 2 * std::ldexp(1, -k);
      const int parts = k <= kWidePanels ? 1 << refined : 1;
      for (int part = 0; part < parts; ++part) edges_.push_back(low * (1 + double(part) / parts));
    }
    edges_.push_back(kPi / 2);
    is_exact_ = !few.empty() && few.size() <= points();
    if (is_exact_) {
      mu_ = few;
      return;
    }
    for (std::size_t panel = 0; panel + 1 < edges_.size(); ++panel)
      for (const double t : nodes().t) mu_.push_back(std::sin(elevation(panel, t)));
  }

  [[nodiscard]] const std::vector<double>& mu() const { return mu_; }
  [[nodiscard]] std::size_t blocks() const { return is_exact_ ? mu_.size() : edges_.size() - 1; }
  // Points of a block.
  [[nodiscard]] std::size_t in_block() const { return is_exact_ ? 1 : kPoints; }

  [[nodiscard]] Place place(double mu) const {
    Place place;
    if (is_exact_) {
      place.first = std::lower_bound(mu_.begin(), mu_.end(), mu) - mu_.begin();
      place.block = place.first;
      place.count = 1;
      place.weight[0] = 1;
      return place;
    }
    const double e = std::asin(std::min(mu, 1.0));
    const auto above = std::upper_bound(edges_.begin() + 1, edges_.end() - 1, e);
    place.block = above - edges_.begin() - 1;
    place.lowest = place.block == 0;
    place.first = place.block * kPoints;
    place.count = kPoints;
    const double low = edges_[place.block], high = edges_[place.block + 1];
    const double share = std::clamp((e - low) / (high - low), 0.0, 1.0);
    const double t = place.block == 0 ? std::cbrt(share) : share;
    double sum = 0;
    for (int k = 0; k < kPoints; ++k) {
      const double off = t - nodes().t[k];
      if (off == 0) {
        place.weight = {};
        place.weight[k] = 1;
        return place;
      }
      place.weight[k] = nodes().weight[k] / off;
      sum += place.weight[k];
    }
    for (double& w : place.weight) w /= sum;
    return place;
  }

 private:
  [[nodiscard]] std::size_t points() const { return (edges_.size() - 1) * kPoints; }
  [[nodiscard]] double elevation(std::size_t panel, double t) const {
    return edges_[panel] + (edges_[panel + 1] - edges_[panel]) * (panel == 0 ? t * t * t : t);
  }

  std::vector<double> edges_;  // elevations
  bool is_exact_ = false;
  std::vector<double> mu_;
};

// More distinct cosines than the finest table has: which ones there are does not matter then.
constexpr std::size_t kManyCosines = 1024;

// Puts `count` elements of a range, its ends among them, where sorting would put them.
void sort_some(std::vector<double>& list, std::size_t count) {
  const auto place = [&](std::size_t k) {
    return list.begin() + static_cast<std::ptrdiff_t>(k * (list.size() - 1) / (count - 1));
  };
  const auto between = [&](auto& self, std::size_t first, std::size_t last) -> void {
    if (last - first < 2) return;
    const std::size_t middle = (first + last) / 2;
    std::nth_element(place(first) + 1, place(middle), place(last));
    self(self, first, middle);
    self(self, middle, last);
  };
  std::nth_element(list.begin(), list.begin(), list.end());
  std::nth_element(list.begin() + 1, list.end() - 1, list.end());
  between(between, 0, count - 1);
}

// Absolute cosines that are asked for on one side of the stack.
struct AskedOfSide {
  bool any = false;
  std::vector<double> few;     // sorted and distinct, unless they are many
  std::vector<double> tested;  // some of them, sorted, the extreme ones among them

  explicit AskedOfSide(std::vector<double> cosines) : any(!cosines.empty()) {
    std::unordered_set<double> seen;
    for (std::size_t k = 0; k < cosines.size() && seen.size() <= kManyCosines; ++k)
      seen.insert(cosines[k]);
    const bool many = seen.size() > kManyCosines;
    if (!many) {
      few.assign(seen.begin(), seen.end());
      std::sort(few.begin(), few.end());
      cosines = few;
    }
    constexpr std::size_t kCount = PairTable::kTests;
    if (cosines.size() <= kCount) {
      tested = std::move(cosines);
      return;
    }
    if (many) sort_some(cosines, kCount);
    for (std::size_t k = 0; k < kCount; ++k)
      tested.push_back(cosines[k * (cosines.size() - 1) / (kCount - 1)]);
  }
};

// Above and below.
using BySide = std::array<AskedOfSide, 2>;

BySide by_side(std::span<const CosinePair> pairs, double CosinePair::*which) {
  std::array<std::vector<double>, 2> mu;
  for (const CosinePair& pair : pairs) mu[pair.*which < 0].push_back(std::abs(pair.*which));
  return {AskedOfSide(std::move(mu[0])), AskedOfSide(std::move(mu[1]))};
}

// Whether pairs may integrate order 2 for themselves (DeterministicField::multiple_refined).
bool has_steep_layer(const Stack& stack) {
  return !stack.has_rough_interfaces() &&
         std::any_of(stack.layers.begin(), stack.layers.end(),
                     [](const Layer& l) { return !l.interface && is_steep(l.medium); });
}

// One entry of the table: sides of the two directions, and their cosines.
std::vector<double> signed_cosines(const std::array<std::vector<double>, 2>& mu) {
  std::vector<double> list = mu[0];
  for (const double m : mu[1]) list.push_back(-m);
  return list;
}

}  // namespace

struct PairTable::Table {
  std::array<std::optional<Side>, 2> in, out;
  std::array<std::size_t, 2> first_in{}, first_out{};  // of each side in the lists of the field
  std::size_t columns = 0, rows = 0;
  struct Channel {
    int modes = 0;
    std::vector<double> f;             // [mode][column][row]
    std::vector<double> scale, bound;  // [column][row], absolute; the bound: largest of a block
  };
  std::vector<Channel> channels;
  std::array<int, 3> channel_of{};

  Table(const DeterministicSolution& solution, const BySide& incident, const BySide& outgoing,
        int refined);
  [[nodiscard]] DeterministicValue value(const Place& i, const Place& o, bool below_i, bool below_o,
                                         double x, Rgb& scale) const;
};

PairTable::Table::Table(const DeterministicSolution& solution, const BySide& incident,
                        const BySide& outgoing, int refined) {
  const auto take = [&](const BySide& asked, auto& sides, auto& first) {
    std::array<std::vector<double>, 2> mu;
    std::size_t count = 0;
    for (int side = 0; side < 2; ++side) {
      first[side] = count;
      if (!asked[side].any) continue;
      sides[side].emplace(asked[side].few, refined);
      mu[side] = sides[side]->mu();
      count += mu[side].size();
    }
    return signed_cosines(mu);
  };
  const std::vector<double> mu_i = take(incident, in, first_in),
                            mu_o = take(outgoing, out, first_out);
  columns = mu_i.size();
  rows = mu_o.size();
  const DeterministicField field = solution.field(mu_i, mu_o);
  // Equal channels share their tables.
  const std::array<int, 3> of = distinct_channels(solution.stack()).channel_of;
  for (int channel = 0; channel < 3; ++channel) {
    channel_of[channel] = of[channel];
    if (channel_of[channel] < static_cast<int>(channels.size())) continue;
    Channel& c = channels.emplace_back();
    c.modes = field.modes(channel);
    c.f.reserve(c.modes * columns * rows);
    for (int m = 0; m < c.modes; ++m)
      for (std::size_t i = 0; i < columns; ++i)
        for (std::size_t o = 0; o < rows; ++o) c.f.push_back(field.mode(channel, 4, m, i, o));
    for (std::size_t i = 0; i < columns; ++i)
      for (std::size_t o = 0; o < rows; ++o) {
        c.scale.push_back(field.scale(channel, i, o));
        c.bound.push_back(field.error_of_mean(channel, i, o, 0));
      }
    // The largest bound of each block takes the place of all in it.
    for (int side_i = 0; side_i < 2; ++side_i)
      for (int side_o = 0; side_o < 2; ++side_o) {
        if (!in[side_i] || !out[side_o]) continue;
        const std::size_t wide = in[side_i]->in_block(), high = out[side_o]->in_block();
        for (std::size_t bi = 0; bi < in[side_i]->blocks(); ++bi)
          for (std::size_t bo = 0; bo < out[side_o]->blocks(); ++bo) {
            const std::size_t i0 = first_in[side_i] + bi * wide, o0 = first_out[side_o] + bo * high;
            double most = 0;
            for (std::size_t i = i0; i < i0 + wide; ++i)
              for (std::size_t o = o0; o < o0 + high; ++o)
                most = std::max(most, c.bound[i * rows + o]);
            c.bound[i0 * rows + o0] = most;
          }
      }
  }
}

DeterministicValue PairTable::Table::value(const Place& i, const Place& o, bool below_i,
                                           bool below_o, double x, Rgb& scale) const {
  const std::size_t column = first_in[below_i] + i.first, row = first_out[below_o] + o.first;
  const double step = 2 * std::cos(x);
  DeterministicValue value;
  std::array<double, 3> sums{}, scales{}, bounds{};
  for (std::size_t k = 0; k < channels.size(); ++k) {
    const Channel& c = channels[k];
    double before = step / 2, now = 1, sum = 0;
    const auto combined = [&](const double* table) {
      double all = 0;
      for (std::size_t a = 0; a < i.count; ++a) {
        const double* const line = table + (column + a) * rows + row;
        double part = 0;
        for (std::size_t b = 0; b < o.count; ++b) part += o.weight[b] * line[b];
        all += i.weight[a] * part;
      }
      return all;
    };
    for (int m = 0; m < c.modes; ++m) {
      sum += (m == 0 ? 1 : 2 * now) * combined(&c.f[m * columns * rows]);
      const double next = step * now - before;
      before = now;
      now = next;
    }
    sums[k] = sum;
    scales[k] = std::abs(combined(c.scale.data()));
    bounds[k] = c.bound[column * rows + row];
  }
  for (int channel = 0; channel < 3; ++channel) {
    value.order[Order::all][channel] = sums[channel_of[channel]];
    value.error[channel] = bounds[channel_of[channel]];
    scale[channel] = scales[channel_of[channel]];
  }
  return value;
}

std::optional<PairTable> PairTable::make(const DeterministicSolution& solution,
                                         std::span<const CosinePair> pairs) {
  if (pairs.size() < kFewestPairs || has_steep_layer(solution.stack())) return std::nullopt;
  const BySide incident = by_side(pairs, &CosinePair::mu_i),
               outgoing = by_side(pairs, &CosinePair::mu_o);
  const std::vector<double> tested_in = signed_cosines({incident[0].tested, incident[1].tested}),
                            tested_out = signed_cosines({outgoing[0].tested, outgoing[1].tested});
  const DeterministicField field = solution.field(tested_in, tested_out);
  const DeterministicAccuracy& accuracy = solution.accuracy();
  const double error = accuracy.error, tolerance = solution.tolerance();
  constexpr std::array<double, 3> kAzimuths{0, 1, kPi};
  for (int refined = 0; refined <= kRefinements; ++refined) {
    PairTable made;
    made.allowed_ = std::numeric_limits<double>::infinity();
    made.table_ = std::make_shared<const Table>(solution, incident, outgoing, refined);
    double worst = 0;
    for (std::size_t i = 0; i < tested_in.size(); ++i)
      for (std::size_t o = 0; o < tested_out.size(); ++o)
        for (const double x : kAzimuths) {
          const auto found = made.at({tested_in[i], tested_out[o]}, x);
          if (!found) continue;
          const DeterministicValue exact = field.multiple(i, o, x);
          for (int channel = 0; channel < 3; ++channel)
            worst = std::max(worst, std::abs(found->order[Order::all][channel] -
                                             exact.order[Order::all][channel]) /
                                        field.scale(channel, i, o));
        }
    made.deviation_ = kSafety * worst;
    if (made.deviation_ > std::max(error, tolerance - error)) continue;
    // A pair that solves for itself owes the nodes' error and what its own tails of modes leave,
    // each at most `error` at the probes. Where that is all that was asked for, tails twice as long
    // are taken here, too, since such a pair costs as much as hundreds from the table.
    made.allowed_ = std::max(std::max(accuracy.node_error, accuracy.energy_defect) + 2 * error,
                             tolerance - made.deviation_);
    return made;
  }
  return std::nullopt;
}

std::optional<DeterministicValue> PairTable::at(CosinePair pair, double x) const {
  const bool below_i = pair.mu_i < 0, below_o = pair.mu_o < 0;
  const Place i = table_->in[below_i]->place(std::abs(pair.mu_i)),
              o = table_->out[below_o]->place(std::abs(pair.mu_o));
  if (i.lowest && o.lowest) return std::nullopt;
  Rgb scale;
  DeterministicValue value = table_->value(i, o, below_i, below_o, x, scale);
  for (int channel = 0; channel < 3; ++channel) {
    if (value.error[channel] > allowed_ * scale[channel]) return std::nullopt;
    value.error[channel] += deviation_ * scale[channel];
  }
  return value;
}

std::size_t PairTable::incident() const { return table_->columns; }
std::size_t PairTable::outgoing() const { return table_->rows; }

}  // namespace lamella
