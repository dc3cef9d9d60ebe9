#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace lamella {

/// What a part file or a checkpoint holds: what it belongs to, and the pieces of a run by their
/// numbers.
///
/// The file: a line "lamella part 1"; the sizes of the header and of the table of pieces (two
/// 64-bit numbers, little-endian as all of them); the header, JSON; per piece its number and its
/// size; the pieces' bytes; the SHA-256 of all before in 64 hexadecimal digits, and a line's end.
struct Part {
  nlohmann::ordered_json header{};
  std::map<std::uint64_t, std::string> pieces{};
};

/// The number of the piece that holds what a run read from elsewhere: direction pairs.
inline constexpr std::uint64_t kInputPiece = std::numeric_limits<std::uint64_t>::max();

/// Writes the whole file or nothing (write_file). Throws OutputError.
void write_part(const std::filesystem::path& path, const Part& part);
/// The same of pieces of which some lie in other files, or in the one that is replaced: no more
/// than one of them is in memory at a time. Throws UsageError, too, where such a file was changed.
void write_part(const std::filesystem::path& path, const nlohmann::ordered_json& header,
                const std::map<std::uint64_t, class StoredPiece>& pieces);

/// The pieces of a part of a run, by their numbers.
class Pieces {
 public:
  Pieces() = default;
  Pieces(const Pieces&) = delete;
  Pieces& operator=(const Pieces&) = delete;
  virtual ~Pieces() = default;

  /// As errors name it.
  [[nodiscard]] virtual std::string name() const = 0;
  [[nodiscard]] virtual bool has(std::uint64_t piece) const = 0;
  /// Throws UsageError where there is none, or it has more than `most` bytes.
  [[nodiscard]] virtual std::string piece(std::uint64_t number, std::uint64_t most) const = 0;
  /// What these pieces must be: of errors.
  [[nodiscard]] virtual std::string allowed() const = 0;
  /// Throws UsageError: "NAME: ...; allowed: ...".
  [[noreturn]] void refuse(const std::string& found) const;
};

/// Pieces in memory: what a rank has sent.
class SentPieces : public Pieces {
 public:
  SentPieces(std::string name, std::map<std::uint64_t, std::string> pieces)
      : name_(std::move(name)), pieces_(std::move(pieces)) {}

  [[nodiscard]] std::string name() const override { return name_; }
  [[nodiscard]] bool has(std::uint64_t piece) const override { return pieces_.contains(piece); }
  [[nodiscard]] std::string piece(std::uint64_t number, std::uint64_t most) const override;
  [[nodiscard]] std::string allowed() const override { return "what a rank of this run sends"; }

 private:
  std::string name_;
  std::map<std::uint64_t, std::string> pieces_;
};

/// A part file that is open: the header in memory, pieces read when they are asked for. The
/// content is untrusted: sizes are held against the file's before there is room made for them.
class PartFile : public Pieces {
 public:
  /// Reads the header and checks the sum. Throws UsageError for what is no part file, is cut off
  /// or damaged, and OutputError where the file cannot be read.
  explicit PartFile(std::filesystem::path path);

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::string name() const override { return path_.string(); }
  [[nodiscard]] const nlohmann::ordered_json& header() const { return header_; }
  /// A member of the header that is a text. Throws UsageError where there is none.
  [[nodiscard]] std::string text(const std::string& key) const;
  [[nodiscard]] bool has(std::uint64_t piece) const override { return places_.contains(piece); }
  [[nodiscard]] std::size_t pieces() const { return places_.size(); }
  [[nodiscard]] std::string piece(std::uint64_t number, std::uint64_t most) const override;
  [[nodiscard]] std::uint64_t size_of(std::uint64_t piece) const;
  /// The numbers of the pieces.
  [[nodiscard]] std::vector<std::uint64_t> numbers() const;
  /// All of it in memory. Throws UsageError where that is more than `most` bytes.
  [[nodiscard]] Part all(std::uint64_t most) const;

  [[nodiscard]] std::string allowed() const override {
    return "a whole part file (--shard) or checkpoint";
  }

 private:
  struct Place {
    std::uint64_t from, size;
  };
  std::filesystem::path path_;
  nlohmann::ordered_json header_;
  std::map<std::uint64_t, Place> places_;
};

/// A piece in memory, or in a part file, from which it is read when it is asked for.
class StoredPiece {
 public:
  explicit StoredPiece(std::string bytes) : bytes_(std::move(bytes)) {}
  StoredPiece(std::shared_ptr<const PartFile> file, std::uint64_t number)
      : file_(std::move(file)), number_(number) {}

  [[nodiscard]] bool is_in_file() const { return file_ != nullptr; }
  [[nodiscard]] std::uint64_t size() const {
    return file_ ? file_->size_of(number_) : bytes_.size();
  }
  /// Throws UsageError where it lies in a file and has more than `most` bytes.
  [[nodiscard]] std::string bytes(
      std::uint64_t most = std::numeric_limits<std::uint64_t>::max()) const {
    return file_ ? file_->piece(number_, most) : bytes_;
  }

 private:
  std::string bytes_{};
  std::shared_ptr<const PartFile> file_{};
  std::uint64_t number_ = 0;
};
using StoredPieces = std::map<std::uint64_t, StoredPiece>;

/// All pieces of a file, none of them read.
[[nodiscard]] StoredPieces pieces_of(const std::shared_ptr<const PartFile>& file);
/// All of them in memory.
[[nodiscard]] std::map<std::uint64_t, std::string> loaded(const StoredPieces& pieces);

}  // namespace lamella
