#include "phase/parameters/one_line.h"

#include <algorithm>

namespace lamella {
namespace {

// Bytes of the UTF-8 character that begins here, or 0 if none does.
std::size_t utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[k]); };
  const unsigned first = byte(0);
  const std::size_t length = first < 0x80                    ? 1
                             : first >= 0xc2 && first < 0xe0 ? 2
                             : first >= 0xe0 && first < 0xf0 ? 3
                             : first >= 0xf0 && first < 0xf5 ? 4
                                                             : 0;
  if (length > text.size()) return 0;
  for (std::size_t k = 1; k < length; ++k)
    if ((byte(k) & 0xc0) != 0x80) return 0;
  return length;
}

}  // namespace

std::string one_line(std::string_view text, std::size_t most) {
  std::string line;
  for (std::size_t k = 0; k < text.size();) {
    const char c = text[k];
    if (const std::size_t end = std::min(text.find_first_not_of(" \t\r\n", k), text.size());
        end > k) {
      // Blanks within a line stay as they are.
      const std::string_view run = text.substr(k, end - k);
      const bool ends_line = run.find_first_of("\r\n") != std::string_view::npos;
      if (!line.empty()) line.append(ends_line ? 1 : std::min(run.size(), most), ' ');
      k = end;
      continue;
    }
    const std::size_t length = utf8_length(text.substr(k));
    const bool printable = length > 1 || (length == 1 && c > ' ' && c < 127);
    const std::string_view piece = printable ? text.substr(k, length) : "?";
    if (line.size() + piece.size() > most) {
      if (most < 3) return line;
      while (line.size() + 3 > most) line.pop_back();
      while (!line.empty() && (static_cast<unsigned char>(line.back()) & 0xc0) == 0x80)
        line.pop_back();
      if (!line.empty() && static_cast<unsigned char>(line.back()) >= 0xc2) line.pop_back();
      return line + "...";
    }
    line += piece;
    k += printable ? length : 1;
  }
  while (!line.empty() && line.back() == ' ') line.pop_back();
  return line;
}

}  // namespace lamella
