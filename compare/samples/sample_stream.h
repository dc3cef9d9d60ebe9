#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "compare/request/run_monitor.h"
#include "compare/request/truth_request.h"
#include "volume/result/walk_samples.h"
#include "volume/walk/incident_law.h"

namespace lamella {

class SampleRun;

/// Walks one by one, of a stack and along directions as TruthRequest has them (its walks are those
/// per direction), or with w_i drawn by every walk.
struct SampleRequest {
  /// Reads the stack's grids; throws std::invalid_argument.
  explicit SampleRequest(TruthRequest of, IncidentLaw law_ = IncidentLaw::fixed)
      : truth(std::move(of)), law(law_), plan(plan_of(truth)) {}

  TruthRequest truth;
  IncidentLaw law;
  Plan plan;
};

/// "fixed", "uniform", "cosine".
[[nodiscard]] std::string to_text(IncidentLaw law);

/// Weights that left, per channel: sums over rows.
struct SampleSums {
  using Channels = std::array<double, 3>;
  /// `straight`: side 2 and -2 at order 0, `specular`: at others.
  Channels reflected{}, transmitted{}, straight{}, specular{};
};

/// The walks of one direction, or of all where w_i is drawn.
struct SampleTotals {
  Direction incident{};  ///< (0, 0, 0) where w_i is drawn
  std::uint64_t walks = 0, rows = 0;
  SampleSums sums{};
};

/// The columns of samples, in the order of files.
inline constexpr int kSampleColumns = 5;

/// A stretch of walks on their way to a file or into memory.
struct SampleChunk {
  WalkSamples samples{};
  SampleSums sums{};
  /// CRC-32 of w_i, w_o, weight, order, side.
  std::array<std::uint32_t, kSampleColumns> checksums{};
};

/// Whole walks, the first first; in the calling thread.
using SampleReceiver = std::function<void(const SampleChunk&)>;

/// Follows the walks of all directions, one direction after the other; memory does not grow with
/// their number. The rows are the same for any number of threads. monitor.stop ends the run between
/// two stretches of walks: those so far are whole. With a keeper stretches are its pieces.
/// Throws std::invalid_argument for what Simulation refuses, NonFiniteError.
[[nodiscard]] std::vector<SampleTotals> stream_samples(const SampleRequest& request,
                                                       const RunMonitor& monitor,
                                                       const SampleReceiver& receive);

/// The pieces that stream_samples has with a keeper, found one by one in any order.
class SamplePieces {
 public:
  explicit SamplePieces(const SampleRequest& request);
  ~SamplePieces();

  [[nodiscard]] std::uint64_t count() const { return ends_.back(); }
  /// Throws as stream_samples.
  [[nodiscard]] std::string find(std::uint64_t piece);

 private:
  [[nodiscard]] std::unique_ptr<SampleRun> run_of(std::size_t direction) const;

  const SampleRequest& request_;
  std::vector<std::uint64_t> ends_{};  // per direction, one past its last piece
  std::unique_ptr<SampleRun> run_;     // of the direction that was asked for last
  std::size_t direction_ = 0;
};

/// The bytes of a column, of kSampleColumns.
[[nodiscard]] std::string_view column_bytes(const WalkSamples& samples, int column);

}  // namespace lamella
