#include "compare/ranks/rank_tasks.h"

#include <exception>
#include <limits>
#include <mutex>
#include <optional>
#include <thread>

#include "volume/result/number_bytes.h"

namespace lamella {
namespace {

// In the place of a task's number: nothing was done yet, or nothing is left to do.
constexpr std::uint64_t kNoTask = std::numeric_limits<std::uint64_t>::max();

std::string with_number(std::uint64_t task, const std::string& found) {
  NumberWriter out;
  out.put(task);
  out.put_text(found);
  return out.take();
}

}  // namespace

std::set<std::uint64_t> serve_tasks(
    Ranks& ranks, const std::vector<std::uint64_t>& tasks, const RankTask& find,
    const std::function<void(std::uint64_t task, const std::string& found)>& keep,
    const StopFlag* stop) {
  std::mutex mutex;
  std::size_t next = 0;
  std::set<std::uint64_t> done;
  std::exception_ptr failure;
  const auto take = [&]() -> std::optional<std::uint64_t> {
    const std::lock_guard lock(mutex);
    if (is_set(stop) || failure || next == tasks.size()) return std::nullopt;
    return tasks[next++];
  };
  const auto deliver = [&](std::uint64_t task, const std::string& found) {
    const std::lock_guard lock(mutex);
    if (failure) return;
    try {
      keep(task, found);
      done.insert(task);
    } catch (...) {
      failure = std::current_exception();
    }
  };
  // The other ranks' messages have a thread of their own, as this one works.
  std::thread server([&] {
    RankPause pause;
    for (int left = ranks.count() - 1; left > 0 && !is_set(stop);) {
      const std::optional<RankMessage> message = ranks.poll();
      if (!message) {
        pause.wait();
        continue;
      }
      pause = {};
      NumberReader in(message->bytes);
      if (const auto task = in.get<std::uint64_t>(); task != kNoTask)
        deliver(task, std::string(in.get_text()));
      const std::optional<std::uint64_t> task = take();
      ranks.send(message->from, with_number(task.value_or(kNoTask), {}));
      if (!task) --left;
    }
  });
  std::exception_ptr own;
  try {
    while (const auto task = take()) {
      const std::string found = find(*task);
      if (is_set(stop)) break;
      deliver(*task, found);
    }
  } catch (...) {
    own = std::current_exception();
    const std::lock_guard lock(mutex);
    if (!failure) failure = own;
  }
  server.join();
  if (failure) std::rethrow_exception(failure);
  return done;
}

void work_on_tasks(Ranks& ranks, const RankTask& find, const StopFlag* stop) {
  std::string message = with_number(kNoTask, {});
  for (;;) {
    ranks.send(0, message);
    std::optional<RankMessage> answer;
    for (RankPause pause; !answer; answer = ranks.poll()) {
      if (is_set(stop)) return;
      pause.wait();
    }
    NumberReader in(answer->bytes);
    const auto task = in.get<std::uint64_t>();
    if (task == kNoTask) return;
    const std::string found = find(task);
    if (is_set(stop)) return;
    message = with_number(task, found);
  }
}

}  // namespace lamella
