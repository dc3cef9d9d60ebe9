#include "compare/samples/sample_stream.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <optional>

#include "compare/files/zip_entries.h"
#include "compare/request/errors.h"
#include "compare/request/run_keeper.h"
#include "phase/math/degrees.h"
#include "volume/result/number_bytes.h"
#include "volume/run/sample_run.h"

namespace lamella {
namespace {

// Walks of a keeper's piece, and chunks per thread that are under way together.
constexpr std::uint64_t kPieceWalks = 1 << 20, kChunksPerThread = 4;

template <class T>
std::string_view bytes_of(const SampleColumn<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

SampleChunk described(WalkSamples samples) {
  SampleChunk chunk{std::move(samples)};
  const WalkSamples& s = chunk.samples;
  for (int k = 0; k < kSampleColumns; ++k) chunk.checksums[k] = checksum(column_bytes(s, k));
  // By side from -2 to 2, and whether the order is 0: no branch on chance.
  SampleSums::Channels by_side[5][2]{};
  for (std::size_t j = 0; j < s.count(); ++j) {
    SampleSums::Channels& to = by_side[s.side[j] + 2][s.order[j] == 0];
    for (int c = 0; c < s.channels; ++c) to[c] += s.weight[s.channels * j + c];
  }
  for (int c = 0; c < s.channels; ++c) {
    for (const int zero : {0, 1}) {
      chunk.sums.reflected[c] += by_side[3][zero][c];
      chunk.sums.transmitted[c] += by_side[1][zero][c];
    }
    chunk.sums.straight[c] = by_side[0][1][c] + by_side[4][1][c];
    chunk.sums.specular[c] = by_side[0][0][c] + by_side[4][0][c];
  }
  return chunk;
}

void add_to(SampleTotals& totals, const SampleChunk& chunk) {
  totals.walks += chunk.samples.walks;
  totals.rows += chunk.samples.count();
  const auto add = [](SampleSums::Channels& to, const SampleSums::Channels& from) {
    for (int c = 0; c < 3; ++c) to[c] += from[c];
  };
  add(totals.sums.reflected, chunk.sums.reflected);
  add(totals.sums.transmitted, chunk.sums.transmitted);
  add(totals.sums.straight, chunk.sums.straight);
  add(totals.sums.specular, chunk.sums.specular);
}

// Samples as the bytes of a piece, and back.
std::string saved(const std::vector<SampleChunk>& chunks) {
  NumberWriter out;
  out.put(static_cast<std::uint64_t>(chunks.size()));
  for (const SampleChunk& chunk : chunks) {
    out.put(chunk.samples.walks);
    out.put(static_cast<std::uint64_t>(chunk.samples.count()));
    for (int k = 0; k < kSampleColumns; ++k) out.put_text(column_bytes(chunk.samples, k));
  }
  return out.take();
}

template <class T>
void read_column(NumberReader& in, SampleColumn<T>& column, std::size_t numbers) {
  const std::string_view bytes = in.get_text();
  if (bytes.size() % sizeof(T) != 0 || bytes.size() / sizeof(T) != numbers)
    throw DamagedBytes("it has a column of another length");
  column.resize(numbers);
  if (numbers > 0) std::memcpy(column.data(), bytes.data(), bytes.size());
}

void read_back(const std::string& bytes, int channels, std::uint64_t most_walks,
               const std::function<void(WalkSamples)>& take) {
  NumberReader in(bytes);
  const auto chunks = in.get<std::uint64_t>();
  std::uint64_t walks = 0;
  for (std::uint64_t k = 0; k < chunks; ++k) {
    WalkSamples samples;
    samples.channels = channels;
    samples.walks = in.get<std::uint64_t>();
    const auto rows = static_cast<std::size_t>(in.get<std::uint64_t>());
    if (rows > in.left() || samples.walks > most_walks - walks)
      throw DamagedBytes("it has more walks than its run");
    walks += samples.walks;
    read_column(in, samples.wi, 3 * rows);
    read_column(in, samples.wo, 3 * rows);
    read_column(in, samples.weight, channels * rows);
    read_column(in, samples.order, rows);
    read_column(in, samples.side, rows);
    take(std::move(samples));
  }
  in.end();
}

std::vector<SampleChunk> chunks_of(const SampleRun& run, std::uint64_t walks, std::uint64_t from,
                                   std::uint64_t to) {
  std::vector<SampleChunk> chunks(to - from);
  tbb::parallel_for(from, to,
                    [&](std::uint64_t k) { chunks[k - from] = described(run.take(k, walks)); });
  return chunks;
}

// Chunks of a keeper's piece.
std::uint64_t piece_chunks(const SampleRun& run) {
  return std::max<std::uint64_t>(1, kPieceWalks / run.chunk_walks());
}

// The walks of one direction.
class Stream {
 public:
  Stream(const SampleRun& run, std::uint64_t walks, std::string label, const RunMonitor& monitor,
         const SampleReceiver& receive, SampleTotals& totals)
      : run_(run),
        walks_(walks),
        chunks_(run.chunks(walks)),
        label_(std::move(label)),
        monitor_(monitor),
        receive_(receive),
        totals_(totals) {}

  void flow() {
    monitor_.keeper ? by_pieces() : by_rounds();
    if (monitor_.finished) monitor_.finished();
  }

 private:
  [[nodiscard]] std::vector<SampleChunk> found(std::uint64_t from, std::uint64_t to) const {
    return chunks_of(run_, walks_, from, to);
  }
  void hand_over(const SampleChunk& chunk) {
    receive_(chunk);
    add_to(totals_, chunk);
  }
  void report() const {
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start_;
    if (monitor_.progress) monitor_.progress(label_, {totals_.walks, walks_, seconds.count()});
  }

  // While some walks are handed over, the next ones are under way.
  void by_rounds() {
    const auto step =
        kChunksPerThread * static_cast<std::uint64_t>(tbb::this_task_arena::max_concurrency());
    std::vector<SampleChunk> ready, coming;
    for (std::uint64_t at = 0; at < chunks_ || !ready.empty();) {
      const std::uint64_t end = monitor_.is_stopped() ? at : std::min(at + step, chunks_);
      tbb::task_group group;
      if (end > at) group.run([&, at] { coming = found(at, end); });
      try {
        for (const SampleChunk& chunk : ready) hand_over(chunk);
      } catch (...) {
        group.wait();
        throw;
      }
      group.wait();
      report();
      if (end == at && at < chunks_) break;
      ready = std::move(coming);
      coming.clear();
      at = end;
    }
  }

  void by_pieces() {
    const std::uint64_t step = piece_chunks(run_);
    for (std::uint64_t at = 0; at < chunks_ && !monitor_.is_stopped(); at += step) {
      const auto bytes =
          monitor_.keeper->piece([&] { return saved(found(at, std::min(at + step, chunks_))); });
      report();
      if (!bytes) continue;
      try {
        read_back(*bytes, run_.plan().channels, walks_ - totals_.walks,
                  [&](WalkSamples samples) { hand_over(described(std::move(samples))); });
      } catch (const DamagedBytes& error) {
        throw UsageError(
            fmt::format("a piece of samples: {}; allowed: parts that lamella wrote", error.what()));
      }
    }
  }

  const SampleRun& run_;
  std::uint64_t walks_, chunks_;
  std::string label_;
  const RunMonitor& monitor_;
  const SampleReceiver& receive_;
  SampleTotals& totals_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace

std::string to_text(IncidentLaw law) {
  return law == IncidentLaw::uniform ? "uniform" : law == IncidentLaw::cosine ? "cosine" : "fixed";
}

std::string_view column_bytes(const WalkSamples& samples, int column) {
  switch (column) {
    case 0:
      return bytes_of(samples.wi);
    case 1:
      return bytes_of(samples.wo);
    case 2:
      return bytes_of(samples.weight);
    case 3:
      return bytes_of(samples.order);
    default:
      return bytes_of(samples.side);
  }
}

SamplePieces::SamplePieces(const SampleRequest& request) : request_(request) {
  const std::size_t directions =
      request.law == IncidentLaw::fixed ? request.truth.directions.size() : 1;
  const std::uint64_t walks = request.truth.effort.walks;
  std::uint64_t end = 0;
  for (direction_ = 0; direction_ < directions; ++direction_) {
    run_ = run_of(direction_);
    const std::uint64_t step = piece_chunks(*run_);
    ends_.push_back(end += (run_->chunks(walks) + step - 1) / step);
  }
  --direction_;
}

SamplePieces::~SamplePieces() = default;

std::unique_ptr<SampleRun> SamplePieces::run_of(std::size_t direction) const {
  const TruthRequest& truth = request_.truth;
  if (request_.law != IncidentLaw::fixed)
    return std::make_unique<SampleRun>(truth.stack, request_.plan, request_.law, truth.seed);
  return std::make_unique<SampleRun>(truth.stack, request_.plan, truth.directions[direction],
                                     truth.seed);
}

std::string SamplePieces::find(std::uint64_t piece) {
  const auto end = std::upper_bound(ends_.begin(), ends_.end(), piece);
  const auto direction = static_cast<std::size_t>(end - ends_.begin());
  if (direction != direction_) {
    run_ = run_of(direction);
    direction_ = direction;
  }
  const std::uint64_t walks = request_.truth.effort.walks, step = piece_chunks(*run_);
  const std::uint64_t at = step * (piece - (direction ? ends_[direction - 1] : 0));
  return saved(chunks_of(*run_, walks, at, std::min(at + step, run_->chunks(walks))));
}

std::vector<SampleTotals> stream_samples(const SampleRequest& request, const RunMonitor& monitor,
                                         const SampleReceiver& receive) {
  const TruthRequest& truth = request.truth;
  const Plan& plan = request.plan;
  for (const std::string& warning : plan.warnings) monitor.warn(warning);
  std::vector<SampleTotals> totals;
  const auto flow = [&](const SampleRun& run, const std::string& label) {
    Stream(run, truth.effort.walks, label, monitor, receive, totals.back()).flow();
  };
  if (request.law != IncidentLaw::fixed) {
    totals.emplace_back();
    flow(SampleRun(truth.stack, plan, request.law, truth.seed), to_text(request.law));
    return totals;
  }
  for (const Direction wi : truth.directions) {
    if (monitor.is_stopped() && !totals.empty()) break;
    totals.push_back({.incident = wi});
    flow(SampleRun(truth.stack, plan, wi, truth.seed),
         fmt::format("theta_i {:g}", theta_degrees(wi)));
  }
  return totals;
}

}  // namespace lamella
