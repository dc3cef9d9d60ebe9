#pragma once

#include <string>

namespace lamella {

/// A stack that Lamella knows by name: a configuration of one of the papers, or a standard case.
struct BuiltinStack {
  std::string name;
  std::string doc;     ///< what it is, and which of its numbers are Lamella's own choice
  std::string source;  ///< where the numbers come from
  std::string toml;
};

}  // namespace lamella
