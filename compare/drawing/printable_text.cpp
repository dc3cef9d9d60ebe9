#include "compare/drawing/printable_text.h"

#include <boost/locale/utf.hpp>
#include <iterator>

namespace lamella {

std::string printable_text(std::string_view utf8) {
  using Utf8 = boost::locale::utf::utf_traits<char>;
  constexpr boost::locale::utf::code_point kReplacement = 0xfffd;
  std::string out;
  for (const char* at = utf8.data(); at != utf8.data() + utf8.size();) {
    const char* next = at;
    auto point = Utf8::decode(next, utf8.data() + utf8.size());
    if (point == boost::locale::utf::illegal || point == boost::locale::utf::incomplete) {
      point = kReplacement;
      // One mark per byte, so that what follows is found again.
      next = at + 1;
    }
    if (point < 0x20 || (point >= 0x7f && point < 0xa0)) point = ' ';
    Utf8::encode(point, std::back_inserter(out));
    at = next;
  }
  return out;
}

}  // namespace lamella
