#include "compare/exchange/tensor_container.h"

#include <fmt/format.h>

#include <bit>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <limits>

namespace lamella {
namespace {

static_assert(std::endian::native == std::endian::little, "tensor files are little-endian");

constexpr char kMagic[] = "tensor_file";  // with its zero, 12 bytes
constexpr std::uint8_t kU8 = 1, kF32 = 10, kF64 = 11;
constexpr std::uint32_t kMostFields = 256;
constexpr std::uint16_t kMostAxes = 8;

template <class T>
void put(std::string& bytes, T value) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  bytes.append(raw, sizeof(T));
}

std::size_t width_of(std::uint8_t type) {
  // 1 u8, 2 i8, 3 u16, 4 i16, 5 u32, 6 i32, 7 u64, 8 i64, 9 f16, 10 f32, 11 f64.
  constexpr std::size_t kWidths[] = {0, 1, 1, 2, 2, 4, 4, 8, 8, 2, 4, 8};
  return type < std::size(kWidths) ? kWidths[type] : 0;
}

// Reads numbers one after the other, never beyond the end.
class Reader {
 public:
  Reader(const std::string& bytes, const std::string& file) : bytes_(bytes), file_(file) {}

  [[noreturn]] void refuse(const std::string& found, const std::string& allowed) const {
    throw FormatError(fmt::format("{}: found {}; allowed: {}", file_, found, allowed));
  }
  std::string text(std::size_t count) {
    if (count > bytes_.size() - at_)
      refuse(fmt::format("the end after {} bytes, inside of the header", bytes_.size()),
             "a whole tensor file");
    at_ += count;
    return bytes_.substr(at_ - count, count);
  }
  template <class T>
  T number() {
    T value;
    std::memcpy(&value, text(sizeof(T)).data(), sizeof(T));
    return value;
  }

 private:
  const std::string& bytes_;
  const std::string& file_;
  std::size_t at_ = 0;
};

}  // namespace

std::string read_format_file(const std::filesystem::path& path) {
  std::error_code error;
  const bool regular = std::filesystem::is_regular_file(path, error);
  const std::uintmax_t size = regular ? std::filesystem::file_size(path, error) : 0;
  if (!regular || error)
    throw FormatError(
        fmt::format("{}: {}; allowed: a file", path.string(), error ? error.message() : "no file"));
  if (size > kMostFormatBytes)
    throw FormatError(fmt::format("{}: found {} bytes; allowed: at most {}", path.string(), size,
                                  kMostFormatBytes));
  std::ifstream in(path, std::ios::binary);
  std::string bytes(size, '\0');
  if (!in.read(bytes.data(), static_cast<std::streamsize>(size)))
    throw FormatError(fmt::format("{}: {}; allowed: a file", path.string(), std::strerror(errno)));
  return bytes;
}

std::string tensor_file(const std::vector<TensorField>& fields) {
  // Twelve bytes of magic, two of version, four of the count, then 13 + name + 8 per axis each.
  std::size_t offset = 18;
  for (const TensorField& f : fields) offset += 13 + f.name.size() + 8 * f.shape.size();
  std::string bytes(kMagic, 12);
  put<std::uint8_t>(bytes, 1);
  put<std::uint8_t>(bytes, 0);
  put(bytes, static_cast<std::uint32_t>(fields.size()));
  for (const TensorField& f : fields) {
    put(bytes, static_cast<std::uint16_t>(f.name.size()));
    bytes += f.name;
    put(bytes, static_cast<std::uint16_t>(f.shape.size()));
    put(bytes, f.is_bytes ? kU8 : kF32);
    put(bytes, static_cast<std::uint64_t>(offset));
    for (const std::uint64_t n : f.shape) put(bytes, n);
    offset += f.is_bytes ? f.bytes.size() : 4 * f.numbers.size();
  }
  for (const TensorField& f : fields)
    if (f.is_bytes)
      bytes += f.bytes;
    else
      bytes.append(reinterpret_cast<const char*>(f.numbers.data()), 4 * f.numbers.size());
  return bytes;
}

std::vector<TensorField> read_tensor_file(const std::string& bytes, const std::string& file) {
  Reader in(bytes, file);
  if (!bytes.starts_with(std::string(kMagic, 12)))
    in.refuse("no \"tensor_file\" at the start", "a tensor file");
  (void)in.text(12);
  const int major = in.number<std::uint8_t>(), minor = in.number<std::uint8_t>();
  if (major != 1 || minor != 0) in.refuse(fmt::format("version {}.{}", major, minor), "1.0");
  const auto count = in.number<std::uint32_t>();
  if (count > kMostFields)
    in.refuse(fmt::format("{} fields", count), fmt::format("at most {}", kMostFields));
  std::vector<TensorField> fields;
  for (std::uint32_t k = 0; k < count; ++k) {
    TensorField field;
    field.name = in.text(in.number<std::uint16_t>());
    const auto axes = in.number<std::uint16_t>();
    const auto type = in.number<std::uint8_t>();
    const auto offset = in.number<std::uint64_t>();
    const std::size_t width = width_of(type);
    if (axes > kMostAxes || width == 0)
      in.refuse(fmt::format("field \"{}\" of {} axes and type {}", field.name, axes, type),
                fmt::format("at most {} axes, types 1 to 11", kMostAxes));
    std::uint64_t numbers = 1;
    for (int a = 0; a < axes; ++a) {
      const auto n = in.number<std::uint64_t>();
      field.shape.push_back(n);
      // More than the file has is refused here, before a product can overflow.
      if (n != 0 && numbers > bytes.size() / n)
        numbers = std::numeric_limits<std::uint32_t>::max();
      else
        numbers *= n;
      if (numbers * width > bytes.size() || offset > bytes.size() - numbers * width)
        in.refuse(fmt::format("field \"{}\" of {} values or more at byte {} of {}", field.name,
                              numbers, offset, bytes.size()),
                  "fields inside of the file");
    }
    if (offset > bytes.size() || numbers * width > bytes.size() - offset)
      in.refuse(fmt::format("field \"{}\" at byte {} of {}", field.name, offset, bytes.size()),
                "fields inside of the file");
    const char* from = bytes.data() + offset;
    if (type == kU8) {
      field.is_bytes = true;
      field.bytes.assign(from, numbers);
    } else if (type == kF32) {
      field.numbers.resize(numbers);
      if (numbers > 0) std::memcpy(field.numbers.data(), from, 4 * numbers);
    } else if (type == kF64) {
      for (std::uint64_t n = 0; n < numbers; ++n) {
        double value;
        std::memcpy(&value, from + 8 * n, 8);
        field.numbers.push_back(static_cast<float>(value));
      }
    } else {
      continue;
    }
    fields.push_back(std::move(field));
  }
  return fields;
}

}  // namespace lamella
