#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace lamella {

/// The content of Lamella's EXR files: named channels of one size and string attributes. Pixels go
/// row by row from the top left; x is the phi cell from phi = 0, y the mu^2 cell from the normal.
struct ExrImage {
  int width = 0, height = 0;
  /// width * height values each
  std::vector<std::pair<std::string, std::vector<float>>> channels{};
  std::map<std::string, std::string> attributes{};
};

}  // namespace lamella
