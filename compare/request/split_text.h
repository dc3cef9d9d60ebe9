#pragma once

#include <string>
#include <vector>

namespace lamella {

/// The parts of a text between a character: "a,,b" has three at ','. An empty text is one part.
[[nodiscard]] std::vector<std::string> split_text(const std::string& text, char at);

}  // namespace lamella
