#include "compare/drawing/picture_text.h"

#include <algorithm>

namespace lamella {

int text_height(Font font) { return font == Font::title ? 17 : 13; }

std::vector<std::string> wrapped(std::string_view utf8, Font font, int width) {
  std::vector<std::string> lines;
  std::string line;
  while (!utf8.empty()) {
    const std::size_t end = std::min(utf8.find(' '), utf8.size());
    const std::string word(utf8.substr(0, end));
    utf8.remove_prefix(std::min(end + 1, utf8.size()));
    std::string longer = line;
    if (!line.empty()) longer += ' ';
    longer += word;
    if (text_width(longer, font) <= width) {
      line = longer;
      continue;
    }
    if (!line.empty()) lines.push_back(line);
    line = shortened(word, font, width);
  }
  if (!line.empty()) lines.push_back(line);
  return lines;
}

std::string shortened(std::string_view utf8, Font font, int width) {
  constexpr std::string_view kEllipsis = "\u2026";
  std::string text(utf8);
  if (text_width(text, font) <= width) return text;
  // The longest beginning that fits, by halving; never in the middle of a character.
  const auto beginning = [&](std::size_t bytes) {
    while (bytes > 0 && (static_cast<unsigned char>(utf8[bytes]) & 0xc0) == 0x80) --bytes;
    return std::string(utf8.substr(0, bytes)).append(kEllipsis);
  };
  std::size_t fits = 0, too_long = utf8.size();
  while (too_long - fits > 1) {
    const std::size_t middle = (fits + too_long) / 2;
    (text_width(beginning(middle), font) <= width ? fits : too_long) = middle;
  }
  return beginning(fits);
}

}  // namespace lamella
