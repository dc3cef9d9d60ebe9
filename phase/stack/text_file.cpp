#include "phase/stack/text_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>

namespace lamella {
namespace {

class OpenFile {
 public:
  explicit OpenFile(const std::string& path)
      : own_(path != "-"),
        // Without O_NONBLOCK, opening a pipe waits for a writer.
        file_(own_ ? ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK) : STDIN_FILENO) {
    if (file_ < 0) throw TextFileError(std::strerror(errno));
  }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile() {
    if (own_ && file_ >= 0) ::close(file_);
  }
  [[nodiscard]] int get() const { return file_; }
  [[nodiscard]] bool own() const { return own_; }

 private:
  bool own_;
  int file_;
};

}  // namespace

std::string read_text_file(const std::string& path, std::size_t most, double seconds) {
  const OpenFile file(path);
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) throw TextFileError(std::strerror(errno));
  if (S_ISDIR(status.st_mode)) throw TextFileError("is a directory");
  const bool pipe = S_ISFIFO(status.st_mode);
  if (file.own() && !pipe && !S_ISREG(status.st_mode)) throw TextFileError("is a device");
  const auto too_long = [&] { return fmt::format("holds more than {} MiB", most >> 20); };
  if (S_ISREG(status.st_mode) && static_cast<std::uint64_t>(status.st_size) > most)
    throw TextFileError(too_long());
  std::string text;
  std::array<char, 1 << 16> buffer{};
  bool waited = !file.own() || !pipe;  // stdin may take its time
  for (;;) {
    if (!waited) {
      pollfd ready{file.get(), POLLIN, 0};
      const int n = ::poll(&ready, 1, static_cast<int>(1000 * seconds));
      if (n < 0 && errno == EINTR) continue;
      if (n == 0)
        throw TextFileError(fmt::format("is a pipe that nobody writes to within {:g} s", seconds));
      waited = true;
      // From here on reads wait for the writer.
      ::fcntl(file.get(), F_SETFL, O_RDONLY);
    }
    const ssize_t n = ::read(file.get(), buffer.data(), buffer.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) throw TextFileError(std::strerror(errno));
    if (n == 0) return text;
    text.append(buffer.data(), static_cast<std::size_t>(n));
    if (text.size() > most) throw TextFileError(too_long());
  }
}

}  // namespace lamella
