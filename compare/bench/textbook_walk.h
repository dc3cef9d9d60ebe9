#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "phase/math/direction.h"

namespace lamella {

/// The baselines of `lamella bench`: random walks in one homogeneous layer, written as a careful
/// user would write them from the papers, in scalar double. They share nothing with the engine but
/// the type of a direction, and have no orders, no ledger, no batches.
///
/// Generator: see TextbookGenerator. Weights are the engine's unless a case says otherwise: the
/// weight times the albedo at each of the first three events, from the fourth on survival with the
/// albedo as probability.
enum class TextbookMedium {
  lambert_sphere,     ///< d'Eon 2021, eq. 6, for the deflection; a frame about the direction
  sggx_mirror,        ///< Heitz et al. 2015: visible normals in a frame about w_i, mirrored
  sggx_lambert,       ///< the same visible normals, cosine law about them
  vmf_lambert,        ///< d'Eon and Weidlich 2024: null collisions, normals from D, cosine law
  vmf_mirror,         ///< the same normals, mirrored
  henyey_greenstein,  ///< inverse of the cumulative distribution; a frame about the direction
};

struct TextbookCase {
  TextbookMedium medium;
  double parameter;  ///< SGGX: alpha; vMF: r; henyey_greenstein: g
  double depth;      ///< thickness times density; infinity for a half space
  double albedo;
  int weighted_events = 3;  ///< from the next one on survival with the albedo as probability
};

enum class TextbookGenerator {
  pcg32,   ///< O'Neill 2014, "PCG: a family of simple fast space-efficient statistically good
           ///< algorithms"; one stream for all walks
  engine,  ///< that of the engine's lanes: xoshiro128+, a stream per walk from (seed, walk)
};

/// What is tallied beside the energies.
enum class TextbookTally {
  none,
  cells,   ///< counts of what leaves above in 16 x 32 cells of equal steps in mu^2 and phi
  points,  ///< next-event estimates of f at given directions
};

struct TextbookResult {
  std::uint64_t walks = 0, collisions = 0;
  double reflected = 0, transmitted = 0;  ///< sums over walks of what leaves above and below
  double reflected2 = 0;                  ///< sum over walks of the square
  /// Sums over walks of estimates of f [1/sr], and of their squares, per cell or point.
  std::vector<double> f, f2;

  [[nodiscard]] double mean_reflected() const { return reflected / static_cast<double>(walks); }
  [[nodiscard]] double reflected_error() const;
};

/// Media that were set up in this process, tables of their cross sections among them: one per
/// TextbookWalk, however often that advances. For the test that set-up is not timed.
[[nodiscard]] std::uint64_t textbook_media_made();

/// A run that can be continued; the result is its sum so far. What a medium needs is set up by the
/// constructor: `advance` is walks and nothing else, as a benchmark wants to time it.
class TextbookWalk {
 public:
  /// Light from above along -wi. `points`: upward directions, for TextbookTally::points.
  TextbookWalk(const TextbookCase& what, Direction wi, TextbookTally tally,
               std::vector<Direction> points, std::uint64_t seed,
               TextbookGenerator generator = TextbookGenerator::pcg32);
  void advance(std::uint64_t walks);
  [[nodiscard]] const TextbookResult& result() const { return result_; }

 private:
  // By value: what is on the stack cannot be what the tallies are written to, so that the compiler
  // keeps it in registers.
  template <class Medium>
  void walk_in(Medium medium, std::uint64_t walks);
  // kUsual: by the number of weighted events that a case has if nothing is said.
  template <bool kUsual, class Medium, class Generator>
  void loop(const Medium& medium, Generator& rng, std::uint64_t walks);

  TextbookCase case_;
  std::function<void(TextbookWalk&, std::uint64_t walks)> advance_;  // with the medium
  Direction wi_;
  TextbookTally tally_;
  std::vector<Direction> points_;
  std::vector<double> rate_;  // per point: extinction along the way out, over its cosine
  TextbookGenerator generator_;
  std::uint64_t seed_, state_, increment_;
  TextbookResult result_;
};

/// In words, for the column `baseline`.
[[nodiscard]] const char* describe(TextbookMedium medium);

}  // namespace lamella
