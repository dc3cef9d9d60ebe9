#pragma once

#include <string_view>

namespace lamella {

/// compare/report/page/page.html as it stood when the program was built.
[[nodiscard]] std::string_view page_template();

}  // namespace lamella
