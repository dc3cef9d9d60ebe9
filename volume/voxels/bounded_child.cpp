#include "volume/voxels/bounded_child.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <new>
#include <utility>

#include "phase/parameters/one_line.h"

namespace lamella {
namespace {

// How a child ends that did not crash. Sanitizers end theirs with 1.
constexpr int kDone = 0, kRefused = 71, kNoMemory = 72, kNotStarted = 73;
constexpr std::size_t kKeptMessage = 400;

// A file descriptor that is closed in the end.
class Descriptor {
 public:
  explicit Descriptor(int file = -1) : file_(file) {}
  Descriptor(Descriptor&& other) noexcept : file_(std::exchange(other.file_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(file_, other.file_);
    return *this;
  }
  ~Descriptor() { close(); }
  void close() {
    if (file_ >= 0) ::close(file_);
    file_ = -1;
  }
  [[nodiscard]] int get() const { return file_; }

 private:
  int file_;
};

struct Pipe {
  Descriptor read, write;

  Pipe() {
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0)
      throw ChildFailure(fmt::format("cannot be started ({})", std::strerror(errno)));
    read = Descriptor(ends[0]);
    write = Descriptor(ends[1]);
  }
};

// A child that is killed and waited for unless that has been done.
class Child {
 public:
  explicit Child(pid_t id) : id_(id) {}
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() {
    if (id_ <= 0) return;
    kill();
    (void)wait();
  }
  void kill() const { ::kill(id_, SIGKILL); }
  // Status as waitpid gives it; -1 where somebody else has waited for all children.
  int wait() {
    int status = 0;
    pid_t ended = 0;
    while ((ended = ::waitpid(id_, &status, 0)) < 0 && errno == EINTR) {
    }
    id_ = 0;
    return ended < 0 ? -1 : status;
  }

 private:
  pid_t id_;
};

// Bytes of address space in use, or 0 where /proc tells nothing.
std::uint64_t address_space() {
  std::uint64_t pages = 0;
  if (std::FILE* file = std::fopen("/proc/self/statm", "re")) {
    unsigned long long read = 0;
    if (std::fscanf(file, "%llu", &read) == 1) pages = read;
    std::fclose(file);
  }
  return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

bool set_limit(int resource, rlim_t value, rlim_t slack = 0) {
  rlimit limit{};
  if (::getrlimit(static_cast<__rlimit_resource>(resource), &limit) != 0) return false;
  limit.rlim_cur = std::min<rlim_t>(value, limit.rlim_max);
  limit.rlim_max = std::min<rlim_t>(value + slack, limit.rlim_max);
  return ::setrlimit(static_cast<__rlimit_resource>(resource), &limit) == 0;
}

// What the child does before its work: dies with its parent, has signals as a fresh process does,
// stdout and stderr go to the pipe, and the limits hold. `in_use`: address space of the parent.
bool prepare_child(const ChildLimits& limits, pid_t parent, std::uint64_t in_use, int messages) {
  if (::prctl(PR_SET_PDEATHSIG, SIGKILL) != 0 || ::getppid() != parent) return false;
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGXCPU, SIGTERM, SIGPIPE})
    std::signal(signal, SIG_DFL);
  // Ctrl-C goes to the parent, which decides what becomes of the run.
  std::signal(SIGINT, SIG_IGN);
  sigset_t none;
  sigemptyset(&none);
  ::sigprocmask(SIG_SETMASK, &none, nullptr);
  const int null = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  if (null < 0 || ::dup2(null, 0) < 0 || ::dup2(messages, 1) < 0 || ::dup2(messages, 2) < 0)
    return false;
  const auto seconds = static_cast<rlim_t>(std::ceil(limits.processor_seconds));
  return set_limit(RLIMIT_CORE, 0) && set_limit(RLIMIT_FSIZE, 0) &&
         set_limit(RLIMIT_CPU, seconds, 2) &&
         (in_use == 0 || set_limit(RLIMIT_AS, in_use + limits.memory));
}

[[noreturn]] void work_and_exit(int file, const std::function<void(ChildAnswer&)>& work) {
  ChildAnswer answer(file);
  try {
    try {
      work(answer);
      answer.flush();
    } catch (const std::bad_alloc&) {
      ::_exit(kNoMemory);
    } catch (const std::exception& error) {
      // The text, and how long it is, behind whatever has been answered.
      const std::uint32_t length = static_cast<std::uint32_t>(std::strlen(error.what()));
      answer.write(error.what(), length);
      answer.write(&length, sizeof length);
      answer.flush();
      ::_exit(kRefused);
    }
  } catch (...) {
    ::_exit(kNoMemory);
  }
  ::_exit(kDone);
}

std::string crash_of(int signal, const ChildLimits& limits, const std::string& message) {
  if (signal == SIGXCPU)
    return fmt::format("took more than {:g} s of processor time", limits.processor_seconds);
  if (signal == SIGKILL) return "was killed, as the system does where memory runs out";
  std::string text = fmt::format("crashed: {}", ::strsignal(signal));
  if (!message.empty()) text += fmt::format(", \"{}\"", one_line(message, 100));
  return text;
}

}  // namespace

void ChildAnswer::write(const void* data, std::size_t count) {
  constexpr std::size_t kPiece = 1 << 16;
  const char* bytes = static_cast<const char*>(data);
  while (count > 0) {
    const std::size_t taken = std::min(count, kPiece - buffer_.size());
    buffer_.insert(buffer_.end(), bytes, bytes + taken);
    bytes += taken;
    count -= taken;
    if (buffer_.size() == kPiece) flush();
  }
}

void ChildAnswer::flush() {
  std::size_t sent = 0;
  while (sent < buffer_.size()) {
    const ssize_t n = ::write(file_, buffer_.data() + sent, buffer_.size() - sent);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) ::_exit(kNotStarted);
    sent += static_cast<std::size_t>(n);
  }
  buffer_.clear();
}

std::string run_in_child(const ChildLimits& limits, const std::function<void(ChildAnswer&)>& work) {
  Pipe answers, messages;
  const pid_t parent = ::getpid();
  const std::uint64_t in_use = address_space();
  const pid_t id = ::fork();
  if (id < 0) throw ChildFailure(fmt::format("cannot be started ({})", std::strerror(errno)));
  if (id == 0) {
    // Away from the numbers that stdin, stdout and stderr take.
    const int file = ::fcntl(answers.write.get(), F_DUPFD_CLOEXEC, 3);
    const int told = ::fcntl(messages.write.get(), F_DUPFD_CLOEXEC, 3);
    if (file < 0 || told < 0 || !prepare_child(limits, parent, in_use, told)) ::_exit(kNotStarted);
    for (Descriptor* end : {&answers.read, &answers.write, &messages.read, &messages.write})
      if (end->get() > 2) end->close();
    ::close(told);
    work_and_exit(file, work);
  }
  Child child(id);
  answers.write.close();
  messages.write.close();

  using Clock = std::chrono::steady_clock;
  const Clock::time_point end =
      Clock::now() + std::chrono::milliseconds(static_cast<std::int64_t>(1000 * limits.seconds));
  std::string answer, message;
  std::size_t told = 0;
  std::vector<char> buffer(1 << 16);
  std::string stopped;
  while (stopped.empty() && (answers.read.get() >= 0 || messages.read.get() >= 0)) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now());
    if (left.count() <= 0) {
      stopped = fmt::format("took more than {:g} s", limits.seconds);
      break;
    }
    std::array<pollfd, 2> ready{
        {{answers.read.get(), POLLIN, 0}, {messages.read.get(), POLLIN, 0}}};
    if (::poll(ready.data(), ready.size(),
               static_cast<int>(std::min<std::int64_t>(left.count(), 1000))) <= 0)
      continue;
    for (int k = 0; k < 2; ++k) {
      if (ready[k].revents == 0) continue;
      Descriptor& from = k == 0 ? answers.read : messages.read;
      const ssize_t n = ::read(from.get(), buffer.data(), buffer.size());
      if (n < 0 && errno == EINTR) continue;
      if (n <= 0) {
        from.close();
        continue;
      }
      const auto count = static_cast<std::size_t>(n);
      if (k == 0) {
        answer.append(buffer.data(), count);
        if (answer.size() > limits.memory)
          stopped = fmt::format("answered with more than {} MiB", limits.memory >> 20);
      } else {
        told += count;
        message.append(buffer.data(), std::min(count, kKeptMessage - message.size()));
        if (told > limits.messages)
          stopped = fmt::format("wrote more than {} KiB of messages", limits.messages >> 10);
      }
    }
  }
  if (!stopped.empty()) throw ChildFailure(stopped);
  const int status = child.wait();
  if (status >= 0 && WIFSIGNALED(status))
    throw ChildFailure(crash_of(WTERMSIG(status), limits, message));
  const int code = status >= 0 && WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  if (code == kNoMemory)
    throw ChildFailure(fmt::format("asked for more than {} MiB of memory", limits.memory >> 20));
  if (code == kRefused) {
    std::uint32_t length = 0;
    if (answer.size() >= sizeof length) {
      std::memcpy(&length, answer.data() + answer.size() - sizeof length, sizeof length);
      if (length <= answer.size() - sizeof length)
        throw ChildRefusal(answer.substr(answer.size() - sizeof length - length, length));
    }
  }
  if (code != kDone)
    throw ChildFailure(fmt::format("ended with status {}{}", code,
                                   message.empty() ? "" : ", \"" + one_line(message, 100) + '"'));
  return answer;
}

}  // namespace lamella
