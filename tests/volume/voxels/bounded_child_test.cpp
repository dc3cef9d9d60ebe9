#include "volume/voxels/bounded_child.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace lamella {
namespace {

constexpr ChildLimits kSmall{
    .memory = 256 << 20, .processor_seconds = 1, .seconds = 20, .messages = 4096};

// What becomes of work that does not end well.
std::string failure_of(const std::function<void(ChildAnswer&)>& work,
                       const ChildLimits& limits = kSmall) {
  try {
    (void)run_in_child(limits, work);
  } catch (const ChildFailure& failure) {
    return failure.what();
  } catch (const ChildRefusal& refusal) {
    return std::string("refusal: ") + refusal.what();
  }
  return "no failure";
}

TEST(BoundedChild, HandsBackWhatTheWorkWrote) {
  const std::string long_text(10'000'000, 'x');
  EXPECT_EQ(run_in_child(kSmall,
                         [&](ChildAnswer& answer) {
                           answer.write(long_text.data(), long_text.size());
                           answer.write("end", 3);
                         }),
            long_text + "end");
  EXPECT_EQ(run_in_child(kSmall, [](ChildAnswer&) {}), "");
}

TEST(BoundedChild, LeavesThisProcessAsItIs) {
  int value = 1;
  (void)run_in_child(kSmall, [&](ChildAnswer&) { value = 2; });
  EXPECT_EQ(value, 1);
  rlimit limit{};
  ASSERT_EQ(getrlimit(RLIMIT_CPU, &limit), 0);
  EXPECT_GT(limit.rlim_cur, rlim_t{1});
}

TEST(BoundedChild, TellsOfCrashesInOneLine) {
  const auto expect = [](const std::string& text, const char* part) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
  };
  expect(failure_of([](ChildAnswer&) { std::raise(SIGSEGV); }), "crashed: Segmentation fault");
  expect(failure_of([](ChildAnswer&) { std::raise(SIGBUS); }), "crashed: Bus error");
  expect(failure_of([](ChildAnswer&) {
           const char text[] = "free(): invalid\npointer\n";
           (void)!::write(2, text, sizeof text - 1);
           std::abort();
         }),
         "crashed: Aborted, \"free(): invalid pointer\"");
  expect(failure_of([](ChildAnswer&) { ::_exit(5); }), "ended with status 5");
  expect(failure_of([](ChildAnswer& answer) {
           answer.write("half", 4);
           throw std::runtime_error("found nothing");
         }),
         "refusal: found nothing");
}

TEST(BoundedChild, EndsWhatTakesTooLongTooMuchOrTalksTooMuch) {
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(failure_of([](ChildAnswer&) {
              for (std::atomic<int> k = 0;; ++k) {
              }
            }),
            "took more than 1 s of processor time");
  EXPECT_EQ(failure_of([](ChildAnswer&) { std::this_thread::sleep_for(std::chrono::hours(1)); },
                       {.memory = 1 << 28, .processor_seconds = 1, .seconds = 0.3}),
            "took more than 0.3 s");
  EXPECT_EQ(failure_of([](ChildAnswer&) {
              const std::string line(1000, ' ');
              for (;;) (void)!::write(2, line.data(), line.size());
            }),
            "wrote more than 4 KiB of messages");
  EXPECT_EQ(failure_of([](ChildAnswer& answer) {
              const std::string piece(1 << 20, ' ');
              for (;;) answer.write(piece.data(), piece.size());
            }),
            "answered with more than 256 MiB");
#ifndef __SANITIZE_ADDRESS__  // whose allocator reserves its addresses in advance
  EXPECT_EQ(failure_of([](ChildAnswer&) {
              // Asked for, never written to: pages that are touched cost processor time.
              std::vector<std::unique_ptr<char[]>> all;
              for (;;) all.push_back(std::make_unique_for_overwrite<char[]>(std::size_t{1} << 24));
            }),
            "asked for more than 256 MiB of memory");
#endif
  // Most of it is the one second of the first; other processes may be in the way.
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(40));
}

TEST(BoundedChild, WorksWhileOtherThreadsAllocate) {
  std::atomic<bool> stop = false;
  std::vector<std::thread> threads;
  for (int k = 0; k < 3; ++k)
    threads.emplace_back([&] {
      while (!stop) (void)std::make_unique<std::string>(10000, 'x');
    });
  for (int k = 0; k < 30; ++k)
    EXPECT_EQ(run_in_child(kSmall,
                           [](ChildAnswer& answer) {
                             const std::string text(20000, 'y');
                             answer.write(text.data(), text.size());
                           })
                  .size(),
              20000u);
  stop = true;
  for (std::thread& thread : threads) thread.join();
}

}  // namespace
}  // namespace lamella
