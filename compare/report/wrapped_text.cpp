#include "compare/report/wrapped_text.h"

#include <algorithm>

namespace lamella {
namespace {

// Code points of UTF-8: continuation bytes take no column.
std::size_t columns_of(std::string_view text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xc0) != 0x80; }));
}

}  // namespace

std::string wrapped(std::string_view first, std::string_view text) {
  return wrapped(first, text, columns_of(first));
}

std::string wrapped(std::string_view first, std::string_view text, std::size_t indent) {
  std::string out(first);
  std::size_t column = columns_of(first), begin = column;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(' '), text.size());
    const std::string_view word = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (word.empty()) continue;
    const std::size_t width = columns_of(word);
    if (column > begin && column + 1 + width > kTerminalWidth) {
      out += '\n' + std::string(indent, ' ');
      column = begin = indent;
    }
    if (column > begin) {
      out += ' ';
      ++column;
    }
    out += word;
    column += width;
  }
  return out + '\n';
}

}  // namespace lamella
