#include "compare/ranks/sent_pieces.h"

#include <sys/resource.h>

#include "volume/result/number_bytes.h"

namespace lamella {

double cpu_seconds() {
  rusage use{};
  getrusage(RUSAGE_SELF, &use);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(use.ru_utime) + seconds(use.ru_stime);
}

std::string sent_pieces(const std::map<std::uint64_t, std::string>& pieces) {
  NumberWriter out;
  out.put(cpu_seconds());
  out.put(static_cast<std::uint64_t>(pieces.size()));
  for (const auto& [number, bytes] : pieces) {
    out.put(number);
    out.put_text(bytes);
  }
  return out.take();
}

ReceivedPieces received_pieces(std::string_view bytes) {
  NumberReader in(bytes);
  ReceivedPieces received;
  received.seconds = in.get<double>();
  const auto count = in.get<std::uint64_t>();
  for (std::uint64_t k = 0; k < count; ++k) {
    const auto number = in.get<std::uint64_t>();
    received.pieces.emplace(number, in.get_text());
  }
  in.end();
  return received;
}

}  // namespace lamella
