#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "phase/stack/map_reference.h"
#include "phase/stack/stack.h"
#include "phase/stack/stack_file_error.h"

namespace lamella {

/// A key of a stack file whose value a picture holds.
struct MappedKey {
  std::optional<std::size_t> layer;  ///< counted from 0 at the top; nothing: the substrate
  std::string key;
  /// What the key takes; nothing where another room knows (keys of a closed form as substrate).
  std::optional<ParameterInfo> info;
  MapReference map;
  std::string where;  ///< "wood.toml:5: layer 0: key \"albedo\"", for errors

  /// "layer.0.albedo", "substrate.albedo".
  [[nodiscard]] std::string path() const;
};

/// A stack some of whose values vary over the surface. It becomes a plain Stack at a place, which
/// every walk, solver and closed form takes: none of them knows maps.
class MappedStack {
 public:
  /// Reads a stack file as parse_stack does (stack_file.h), with pictures among its values. Throws
  /// StackFileError.
  MappedStack(std::string_view text, const std::string& file, std::string name);
  MappedStack(MappedStack&&) noexcept;
  MappedStack& operator=(MappedStack&&) noexcept;
  ~MappedStack();

  [[nodiscard]] const std::string& name() const;
  /// The keys with pictures, in the file's order of layers; none: a plain stack.
  [[nodiscard]] const std::vector<MappedKey>& maps() const;
  /// The stack with these values, one per key, in the place of the pictures. Throws StackFileError
  /// where a value or their combination is not allowed.
  [[nodiscard]] Stack with(const std::vector<ParameterValue>& values) const;
  /// The stack of a file without pictures. Throws StackFileError, which names the first picture.
  [[nodiscard]] Stack plain() const;

 private:
  struct Content;
  std::unique_ptr<Content> content_;
};

}  // namespace lamella
