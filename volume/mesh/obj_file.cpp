#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <map>
#include <string>
#include <string_view>

#include "volume/mesh/triangle_mesh.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kMostBytes = std::uintmax_t{512} << 20;

class ObjReader {
 public:
  explicit ObjReader(const fs::path& path) : path_(path) {}

  TriangleMesh read() {
    std::ifstream in(path_);
    if (!in) throw MeshError(fmt::format("{}: cannot be read", path_.string()));
    for (std::string line; std::getline(in, line);) {
      ++line_;
      if (!line.empty() && line.back() == '\r') line.pop_back();
      take(line);
    }
    if (mesh_.triangles.empty()) fail("no faces", "lines \"f a b c ...\"");
    for (std::size_t k = 0; k < mesh_.vertices.size(); ++k) {
      TriangleMesh::Vertex& vertex = mesh_.vertices[k];
      if (!has_normal_[k]) vertex.normal = sums_[position_of_[k]];
      const double size = length(vertex.normal);
      vertex.normal = size > 0 ? (1 / size) * vertex.normal : Direction{0, 1, 0};
    }
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void fail(const std::string& found, const std::string& allowed) const {
    throw MeshError(
        fmt::format("{}:{}: found {}; allowed: {}", path_.string(), line_, found, allowed));
  }

  static std::string_view next_word(std::string_view& left) {
    const std::size_t begin = left.find_first_not_of(" \t");
    if (begin == std::string_view::npos) return left = {};
    left.remove_prefix(begin);
    const std::string_view word = left.substr(0, left.find_first_of(" \t"));
    left.remove_prefix(word.size());
    return word;
  }

  double number(std::string_view& left) const {
    const std::string_view word = next_word(left);
    double value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc{} || end != word.data() + word.size() || !(std::abs(value) < 1e15))
      fail(fmt::format("\"{}\"", word.substr(0, 40)), "a number between -1e15 and 1e15");
    return value;
  }

  // An index as OBJ counts: from 1, or back from the end; 0 where there is none.
  std::size_t index(std::string_view word, std::size_t count) const {
    if (word.empty()) return 0;
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    const auto all = static_cast<std::int64_t>(count);
    if (value < 0) value += all + 1;
    if (error != std::errc{} || end != word.data() + word.size() || value < 1 || value > all)
      fail(fmt::format("the index \"{}\"", word.substr(0, 40)),
           fmt::format("1 to {}, or -{} to -1", count, count));
    return static_cast<std::size_t>(value);
  }

  std::uint32_t vertex(std::string_view word) {
    std::array<std::string_view, 3> parts{};
    for (std::string_view& part : parts) {
      const std::size_t slash = std::min(word.find('/'), word.size());
      part = word.substr(0, slash);
      word.remove_prefix(std::min(slash + 1, word.size()));
    }
    const std::array<std::size_t, 3> key{index(parts[0], positions_.size()),
                                         index(parts[1], places_.size()),
                                         index(parts[2], normals_.size())};
    if (key[0] == 0) fail("a vertex without a position", "v, v/vt, v//vn or v/vt/vn");
    const auto [known, is_new] =
        vertices_.emplace(key, static_cast<std::uint32_t>(mesh_.vertices.size()));
    if (is_new) {
      TriangleMesh::Vertex made{positions_[key[0] - 1], {0, 0, 0}, 0, 0};
      if (key[1]) {
        made.u = places_[key[1] - 1][0];
        made.v = places_[key[1] - 1][1];
      }
      if (key[2]) made.normal = normals_[key[2] - 1];
      has_normal_.push_back(key[2] && length(made.normal) > 0);
      position_of_.push_back(key[0] - 1);
      mesh_.vertices.push_back(made);
    }
    return known->second;
  }

  void face(std::string_view left) {
    std::vector<std::uint32_t> corners;
    for (std::string_view word = next_word(left); !word.empty(); word = next_word(left))
      corners.push_back(vertex(word));
    if (corners.size() < 3)
      fail(fmt::format("a face of {} vertices", corners.size()), "3 and more");
    for (std::size_t k = 2; k < corners.size(); ++k) {
      const std::array<std::uint32_t, 3> triangle{corners[0], corners[k - 1], corners[k]};
      if (mesh_.triangles.size() == kMostTriangles)
        fail("one more triangle", fmt::format("at most {}", kMostTriangles));
      mesh_.triangles.push_back(triangle);
      const auto& at = mesh_.vertices;
      // As long as the area: large triangles count more.
      const Direction normal = cross(at[triangle[1]].position - at[triangle[0]].position,
                                     at[triangle[2]].position - at[triangle[0]].position);
      sums_.resize(positions_.size(), {0, 0, 0});
      for (const std::uint32_t corner : triangle) {
        Direction& sum = sums_[position_of_[corner]];
        sum = sum + normal;
      }
    }
  }

  void take(std::string_view line) {
    const std::string_view word = next_word(line);
    if (word == "v" || word == "vn") {
      Direction d{};
      d.x = number(line);
      d.y = number(line);
      d.z = number(line);
      (word == "v" ? positions_ : normals_).push_back(d);
    } else if (word == "vt") {
      const double u = number(line);
      places_.push_back(
          {u, line.find_first_not_of(" \t") == std::string_view::npos ? 0 : number(line)});
    } else if (word == "f") {
      face(line);
    }
  }

  fs::path path_;
  std::size_t line_ = 0;
  TriangleMesh mesh_;
  std::vector<Direction> positions_, normals_, sums_;
  std::vector<std::array<double, 2>> places_;
  std::map<std::array<std::size_t, 3>, std::uint32_t> vertices_;
  std::vector<bool> has_normal_;
  std::vector<std::size_t> position_of_;
};

}  // namespace

TriangleMesh read_obj(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error))
    throw MeshError(fmt::format("{}: found no file; allowed: a Wavefront OBJ file", path.string()));
  if (const std::uintmax_t size = fs::file_size(path); size > kMostBytes)
    throw MeshError(
        fmt::format("{}: found {} bytes; allowed: at most {}", path.string(), size, kMostBytes));
  return ObjReader(path).read();
}

}  // namespace lamella
