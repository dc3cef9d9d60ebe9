#pragma once

#include <optional>
#include <string_view>

#include "phase/stack/key_reader.h"
#include "phase/stack/map_reference.h"

namespace lamella {

/// Whether a value of a stack file stands for a picture: the name of a .exr, .png, .jpg or .jpeg
/// file, or a table with the key "map".
[[nodiscard]] bool names_picture(const toml::node& node);

/// The picture that a value names. `where`: the part of the stack in errors, "layer 0". Throws
/// StackFileError.
[[nodiscard]] MapReference read_map(const KeyReader& keys, const toml::node& node,
                                    const std::string& where, const std::string& key);

/// What a key of a layer or substrate takes, by the medium, interface or conductor that the table
/// names; nothing where no such key is known here.
[[nodiscard]] std::optional<ParameterInfo> known_key(const toml::table& table, bool substrate,
                                                     std::string_view key);

}  // namespace lamella
