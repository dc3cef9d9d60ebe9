#include "compare/shards/part_file.h"

#include <fmt/format.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <system_error>
#include <utility>

#include "compare/files/content_hash.h"
#include "compare/files/output_folder.h"
#include "compare/request/errors.h"
#include "volume/result/number_bytes.h"

namespace lamella {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

constexpr std::string_view kMagic = "lamella part ";
constexpr std::string_view kFormat = "lamella part 1\n";
constexpr std::uint64_t kDigits = 64, kSumBytes = kDigits + 1;
constexpr std::uint64_t kSizesBytes = 2 * sizeof(std::uint64_t);
constexpr std::uint64_t kEntryBytes = 2 * sizeof(std::uint64_t);
// A stack of a thousand layers takes some 200 KB.
constexpr std::uint64_t kMostHeaderBytes = std::uint64_t{4} << 20;
// The points of a sweep, or incident directions of pairs.
constexpr std::uint64_t kMostPieces = std::uint64_t{1} << 22;
constexpr int kMostDepth = 8;

std::ifstream opened(const fs::path& path) {
  std::error_code error;
  const auto status = fs::status(path, error);
  if (fs::exists(status) && !fs::is_regular_file(status))
    throw OutputError(fmt::format("cannot read {}: it is no regular file", path.string()));
  std::ifstream in(path, std::ios::binary);
  if (!in)
    throw OutputError(
        fmt::format("cannot read {}: {}", path.string(), std::generic_category().message(errno)));
  return in;
}

std::string bytes_at(const fs::path& path, std::uint64_t from, std::uint64_t size) {
  std::ifstream in = opened(path);
  std::string bytes(static_cast<std::size_t>(size), '\0');
  in.seekg(static_cast<std::streamoff>(from));
  in.read(bytes.data(), static_cast<std::streamsize>(size));
  if (static_cast<std::uint64_t>(in.gcount()) != size)
    throw UsageError(fmt::format("{}: it became shorter while it was read", path.string()));
  return bytes;
}

// Objects and lists within one another, no deeper than what is written.
Json parsed(const std::string& text) {
  bool deep = false;
  const auto shallow = [&](int depth, Json::parse_event_t, Json&) {
    deep = deep || depth > kMostDepth;
    return !deep;
  };
  Json json = Json::parse(text, shallow, false);
  return deep || !json.is_object() ? Json() : json;
}

}  // namespace

void write_part(const fs::path& path, const Part& part) {
  StoredPieces pieces;
  for (const auto& [number, bytes] : part.pieces) pieces.emplace(number, StoredPiece(bytes));
  write_part(path, part.header, pieces);
}

void write_part(const fs::path& path, const Json& header_json, const StoredPieces& pieces) {
  const std::string header = header_json.dump();
  NumberWriter sizes, table;
  sizes.put(static_cast<std::uint64_t>(header.size()));
  sizes.put(static_cast<std::uint64_t>(pieces.size()));
  for (const auto& [number, piece] : pieces) {
    table.put(number);
    table.put(piece.size());
  }
  write_file(path, [&](const AddBytes& add) {
    ContentHash hash;
    const auto put = [&](std::string_view bytes) {
      hash.add(bytes);
      add(bytes);
    };
    put(kFormat);
    put(sizes.take());
    put(header);
    put(table.take());
    for (const auto& [number, piece] : pieces) put(piece.bytes());
    add(hash.digits() + '\n');
  });
}

StoredPieces pieces_of(const std::shared_ptr<const PartFile>& file) {
  StoredPieces pieces;
  for (const std::uint64_t number : file->numbers())
    pieces.emplace(number, StoredPiece(file, number));
  return pieces;
}

std::map<std::uint64_t, std::string> loaded(const StoredPieces& pieces) {
  std::map<std::uint64_t, std::string> all;
  for (const auto& [number, piece] : pieces) all.emplace(number, piece.bytes());
  return all;
}

std::string SentPieces::piece(std::uint64_t number, std::uint64_t most) const {
  const auto found = pieces_.find(number);
  if (found == pieces_.end()) refuse(fmt::format("found no piece {} in it", number));
  if (found->second.size() > most)
    refuse(fmt::format("found {} bytes in piece {}, which has at most {}", found->second.size(),
                       number, most));
  return found->second;
}

PartFile::PartFile(fs::path path) : path_(std::move(path)) {
  opened(path_);
  std::error_code error;
  const std::uint64_t size = fs::file_size(path_, error);
  if (error) throw OutputError(fmt::format("cannot read {}: {}", path_.string(), error.message()));
  const std::string start = bytes_at(path_, 0, std::min<std::uint64_t>(size, kFormat.size()));
  if (start != kFormat) {
    if (start.starts_with(kMagic) && start.size() == kFormat.size())
      refuse("found another format of part files, of another version of lamella");
    refuse(size == 0 ? "found nothing in it" : "found something else in it");
  }
  const std::uint64_t fixed = kFormat.size() + kSizesBytes + kSumBytes;
  const auto cut = [&](bool is_cut) {
    if (is_cut) refuse("found its beginning alone: it was cut off");
  };
  cut(size < fixed);
  const std::string two = bytes_at(path_, kFormat.size(), kSizesBytes);
  NumberReader sizes(two);
  const auto header_size = sizes.get<std::uint64_t>(), count = sizes.get<std::uint64_t>();
  if (header_size > kMostHeaderBytes || count > kMostPieces)
    refuse("found sizes that no part has: it is damaged");
  cut(size - fixed < header_size || size - fixed - header_size < count * kEntryBytes);
  const std::uint64_t table_at = kFormat.size() + kSizesBytes + header_size;
  std::uint64_t from = table_at + count * kEntryBytes;
  const std::uint64_t end = size - kSumBytes;
  const std::string table = bytes_at(path_, table_at, count * kEntryBytes);
  NumberReader entries(table);
  for (std::uint64_t k = 0; k < count; ++k) {
    const auto number = entries.get<std::uint64_t>(), bytes = entries.get<std::uint64_t>();
    cut(bytes > end - from);
    if (!places_.try_emplace(number, Place{from, bytes}).second)
      refuse("found a piece twice in it: it is damaged");
    from += bytes;
  }
  if (from != end) refuse("found more bytes than its pieces take: it is damaged");
  const std::string sum = bytes_at(path_, end, kSumBytes);
  if (sum.substr(0, kDigits) != content_hash_of_file(path_, end) || sum.back() != '\n')
    refuse("its content has another sha256 than it says: it is damaged");
  header_ = parsed(bytes_at(path_, kFormat.size() + kSizesBytes, header_size));
  if (header_.is_null()) refuse("found no header in it: it is damaged");
}

std::string PartFile::text(const std::string& key) const {
  const auto found = header_.find(key);
  if (found == header_.end() || !found->is_string())
    refuse(fmt::format("found no \"{}\" in its header", key));
  return found->get<std::string>();
}

std::string PartFile::piece(std::uint64_t number, std::uint64_t most) const {
  const auto found = places_.find(number);
  if (found == places_.end()) refuse(fmt::format("found no piece {} in it", number));
  if (found->second.size > most)
    refuse(fmt::format("found {} bytes in piece {}, which has at most {}", found->second.size,
                       number, most));
  return bytes_at(path_, found->second.from, found->second.size);
}

std::uint64_t PartFile::size_of(std::uint64_t piece) const { return places_.at(piece).size; }

std::vector<std::uint64_t> PartFile::numbers() const {
  std::vector<std::uint64_t> numbers;
  for (const auto& [number, place] : places_) numbers.push_back(number);
  return numbers;
}

Part PartFile::all(std::uint64_t most) const {
  Part part{header_, {}};
  for (const auto& [number, place] : places_) {
    part.pieces[number] = piece(number, most);
    most -= place.size;
  }
  return part;
}

void Pieces::refuse(const std::string& found) const {
  throw UsageError(fmt::format("{}: {}; allowed: {}", name(), found, allowed()));
}

}  // namespace lamella
