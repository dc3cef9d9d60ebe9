#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "phase/stack/stack.h"

namespace lamella {

/// One parameter of a sweep and the values it takes.
struct SweepAxis {
  std::string path;  ///< "layer.0.roughness", "substrate.albedo"
  std::vector<double> values;
};

/// Reads "PATH=FROM:TO:COUNT", "PATH=FROM:TO:COUNT:log" or "PATH=A,B,C". Throws UsageError.
[[nodiscard]] SweepAxis parse_sweep_axis(const std::string& text);

/// The stack file text of a stack with some of its numbers replaced, layers counted from 0 at the
/// top. A key that the stack leaves out is added, and one that says the same in other words
/// (roughness, alpha) is dropped. Throws UsageError for a path that leads nowhere; whether a value
/// is allowed is for the stack's reader to say.
[[nodiscard]] std::string with_values(const Stack& stack, const std::vector<SweepAxis>& axes,
                                      const std::vector<std::size_t>& at);

/// The same with texts of TOML, "0.5" or "[1, 0.5, 0.2]", by their paths. `option`: the option that
/// an error names.
[[nodiscard]] std::string with_texts(const Stack& stack,
                                     const std::vector<std::pair<std::string, std::string>>& texts,
                                     const std::string& option = "--set");
/// The text of a key in the stack's file; nothing where it is left out. Throws UsageError for a
/// path that leads to no part of the stack.
[[nodiscard]] std::optional<std::string> text_at(const Stack& stack, const std::string& path,
                                                 const std::string& option = "--set");

}  // namespace lamella
