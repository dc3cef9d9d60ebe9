#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <map>
#include <mutex>
#include <numeric>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "compare/command/sample_command.h"
#include "compare/ranks/rank_tasks.h"
#include "compare/request/run_keeper.h"

namespace lamella {
namespace {

// Hands pieces to the run that writes them, in its order, as soon as they are there.
class ArrivingPieces : public RunKeeper {
 public:
  explicit ArrivingPieces(const StopFlag* stop) : stop_(stop) {}

  [[nodiscard]] Found begin(Simulation&) override { return {}; }
  void checkpoint(const Simulation&, double, bool) override {}
  void end(const Simulation&, double) override {}
  [[nodiscard]] std::optional<std::string> piece(const Make&) override {
    std::unique_lock lock(mutex_);
    while (!is_set(stop_) && !is_over_ && !there_.contains(next_))
      changed_.wait_for(lock, std::chrono::milliseconds(20));
    const auto found = there_.find(next_++);
    if (found == there_.end()) return std::nullopt;
    std::string bytes = std::move(found->second);
    there_.erase(found);
    return bytes;
  }

  void arrive(std::uint64_t piece, const std::string& bytes) {
    const std::lock_guard lock(mutex_);
    there_.emplace(piece, bytes);
    changed_.notify_one();
  }
  // No further piece comes.
  void close() {
    const std::lock_guard lock(mutex_);
    is_over_ = true;
    changed_.notify_one();
  }

 private:
  const StopFlag* stop_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::uint64_t, std::string> there_;
  std::uint64_t next_ = 0;
  bool is_over_ = false;
};

}  // namespace

int samples_by_ranks(const SampleRequest& request, const RunMonitor& monitor, Ranks& ranks,
                     const std::function<int(const RunMonitor&)>& finish) {
  SamplePieces pieces(request);
  const RankTask find = [&](std::uint64_t k) { return pieces.find(k); };
  if (ranks.rank() != 0) {
    work_on_tasks(ranks, find, monitor.stop);
    return 0;
  }
  std::vector<std::uint64_t> tasks(pieces.count());
  std::iota(tasks.begin(), tasks.end(), 0);
  ArrivingPieces arriving(monitor.stop);
  RunMonitor writing = monitor;
  writing.keeper = &arriving;
  int status = 0;
  std::atomic<bool> failed = false;
  std::exception_ptr failure;
  std::thread writer([&] {
    try {
      status = finish(writing);
    } catch (...) {
      failure = std::current_exception();
      failed = true;
    }
  });
  std::exception_ptr own;
  try {
    (void)serve_tasks(
        ranks, tasks, find,
        [&](std::uint64_t k, const std::string& found) {
          if (failed) std::rethrow_exception(failure);
          arriving.arrive(k, found);
        },
        monitor.stop);
  } catch (...) {
    own = std::current_exception();
  }
  arriving.close();
  writer.join();
  if (failure) std::rethrow_exception(failure);
  if (own) std::rethrow_exception(own);
  return status;
}

}  // namespace lamella
