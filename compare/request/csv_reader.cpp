#include "compare/request/csv_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "compare/request/errors.h"
#include "compare/request/numbers.h"

namespace lamella {
namespace {

// Longer than any line of numbers: a file with a longer line is no table of text.
constexpr std::size_t kLongestLine = 4096;
constexpr std::size_t kLongestShown = 100;
constexpr const char* kAllowedFile = "lines of comma-separated numbers in UTF-8";

std::string without_outer_blanks(std::string_view text) {
  const std::size_t from = text.find_first_not_of(" \t");
  if (from == std::string_view::npos) return "";
  return std::string(text.substr(from, text.find_last_not_of(" \t") + 1 - from));
}

}  // namespace

std::string shown(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (out.size() >= kLongestShown) return out + "...";
    if ((c >= 0 && c < ' ') || c == 127)
      out += fmt::format("\\x{:02x}", static_cast<unsigned>(c));
    else
      out += c;
  }
  return out;
}

CsvReader::CsvReader(std::istream& in, std::string file) : in_(in), file_(std::move(file)) {}

void CsvReader::refuse(const std::string& found, const std::string& allowed) const {
  throw UsageError(fmt::format("{}:{}: found \"{}\"{}{}; allowed: {}", file_, line_, shown(text_),
                               found.empty() ? "" : ", ", found, allowed));
}

bool CsvReader::read_line() {
  text_.clear();
  ++line_;
  for (int c = in_.get(); c != std::istream::traits_type::eof(); c = in_.get()) {
    if (c == '\n') {
      if (text_.ends_with('\r')) text_.pop_back();
      return true;
    }
    text_ += static_cast<char>(c);
    if (text_.size() > kLongestLine)
      refuse(fmt::format("a line of more than {} bytes{}", kLongestLine,
                         text_.find('\r') < kLongestLine ? " with carriage returns inside" : ""),
             kAllowedFile);
  }
  if (text_.ends_with('\r')) text_.pop_back();
  return !text_.empty();
}

std::vector<std::string> CsvReader::fields() const {
  std::vector<std::string> list;
  std::size_t at = 0;
  while (true) {
    const std::size_t first = std::min(text_.find_first_not_of(" \t", at), text_.size());
    if (first < text_.size() && text_[first] == '"' && text_[first] != separator_) {
      std::string field;
      std::size_t k = first + 1;
      for (;; ++k) {
        if (k >= text_.size()) refuse("a quote without its end", "quotes around a whole field");
        if (text_[k] != '"') {
          field += text_[k];
        } else if (k + 1 < text_.size() && text_[k + 1] == '"') {
          field += text_[k++];
        } else {
          break;
        }
      }
      list.push_back(without_outer_blanks(field));
      at = std::min(text_.find(separator_, k), text_.size());
      if (!without_outer_blanks(text_.substr(k + 1, at - k - 1)).empty())
        refuse("text beside a quoted field", "quotes around a whole field");
    } else {
      const std::size_t end = std::min(text_.find(separator_, at), text_.size());
      list.push_back(without_outer_blanks(std::string_view(text_).substr(at, end - at)));
      at = end;
    }
    if (at >= text_.size()) return list;
    ++at;
  }
}

std::optional<std::vector<std::string>> CsvReader::next() {
  while (read_line()) {
    if (line_ == 1 && text_.starts_with("\xef\xbb\xbf")) text_.erase(0, 3);
    if (line_ == 1 && (text_.starts_with("\xff\xfe") || text_.starts_with("\xfe\xff")))
      refuse("the byte order mark of UTF-16", kAllowedFile);
    if (text_.find('\0') != std::string::npos) refuse("a zero byte", kAllowedFile);
    if (without_outer_blanks(text_).empty()) continue;
    if (separator_ == 0 && text_.size() == 5 && text_.starts_with("sep=")) {
      separator_ = text_[4];
      if (separator_ != ',' && separator_ != ';' && separator_ != '\t')
        refuse("", "sep=, or sep=; or sep= and a tab");
      continue;
    }
    if (separator_ == 0)
      separator_ = text_.find(';') != std::string::npos   ? ';'
                   : text_.find(',') != std::string::npos ? ','
                                                          : '\t';
    return fields();
  }
  return std::nullopt;
}

std::optional<std::string> CsvReader::number_text(const std::string& field) {
  std::string text = field;
  if (const std::size_t mark = text.find_first_of(separator_ == ',' ? "." : ",.");
      mark != std::string::npos) {
    if (decimal_mark_ == 0) decimal_mark_ = text[mark];
    if (text[mark] != decimal_mark_) return std::nullopt;
    text[mark] = '.';
  }
  if (!parse_number(text)) return std::nullopt;
  return text;
}

}  // namespace lamella
