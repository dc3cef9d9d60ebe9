#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>

namespace lamella {

/// Bytes that no NumberWriter wrote: what() says what is wrong with them.
struct DamagedBytes : std::runtime_error {
  using std::runtime_error::runtime_error;
};

static_assert(std::endian::native == std::endian::little, "files hold little-endian numbers");

/// Appends numbers to a text of bytes, as memory has them.
class NumberWriter {
 public:
  template <class T>
  void put(const T& value) {
    static_assert(std::is_arithmetic_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }
  template <class T>
  void put_all(std::span<const T> values) {
    static_assert(std::is_arithmetic_v<T>);
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size_bytes());
  }
  /// The number of bytes, then the bytes.
  void put_text(std::string_view text) {
    put(static_cast<std::uint64_t>(text.size()));
    bytes_.append(text);
  }
  [[nodiscard]] std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

/// Reads what NumberWriter wrote, in the same order. Throws DamagedBytes before it reads, or makes
/// room for, more than there is.
class NumberReader {
 public:
  explicit NumberReader(std::string_view bytes) : bytes_(bytes) {}

  template <class T>
  [[nodiscard]] T get() {
    static_assert(std::is_arithmetic_v<T>);
    T value;
    std::memcpy(&value, take(sizeof(T)).data(), sizeof(T));
    return value;
  }
  template <class T>
  void fill(std::span<T> values) {
    static_assert(std::is_arithmetic_v<T>);
    const std::string_view from = take(values.size_bytes());
    if (!values.empty()) std::memcpy(values.data(), from.data(), from.size());
  }
  [[nodiscard]] std::string_view get_text() {
    const auto size = get<std::uint64_t>();
    if (size > bytes_.size()) throw DamagedBytes("it ends within a text");
    return take(static_cast<std::size_t>(size));
  }
  /// How many bytes are left.
  [[nodiscard]] std::size_t left() const { return bytes_.size(); }
  /// Throws DamagedBytes where something is left.
  void end() const {
    if (!bytes_.empty()) throw DamagedBytes("it has more bytes than its numbers take");
  }

 private:
  std::string_view take(std::size_t size) {
    if (size > bytes_.size()) throw DamagedBytes("it ends within a number");
    const std::string_view part = bytes_.substr(0, size);
    bytes_.remove_prefix(size);
    return part;
  }

  std::string_view bytes_;
};

}  // namespace lamella
