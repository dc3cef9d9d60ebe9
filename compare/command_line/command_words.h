#pragma once

#include <string>
#include <string_view>

namespace CLI {
class App;
}

namespace lamella {

/// A completion script of the whole program, made from the definitions of its commands. shell: bash
/// or zsh.
[[nodiscard]] std::string completion_script(const CLI::App& app, std::string_view shell);

/// The manual page in man(7) form, made from the same definitions.
[[nodiscard]] std::string man_page(const CLI::App& app);

}  // namespace lamella
