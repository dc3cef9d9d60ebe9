#include "tests/fuzz/input_readers.h"

#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "compare/exchange/exported.h"
#include "compare/exchange/npz_reader.h"
#include "compare/exchange/tensor_container.h"
#include "compare/files/content_hash.h"
#include "compare/files/exr_file.h"
#include "compare/files/exr_parts.h"
#include "compare/files/picture_file.h"
#include "compare/files/zip_entries.h"
#include "compare/library/library_index.h"
#include "compare/options/run_settings.h"
#include "compare/report/lobe_files.h"
#include "compare/report/lobe_set.h"
#include "compare/request/direction_pairs.h"
#include "compare/request/errors.h"
#include "compare/request/model_request.h"
#include "compare/shards/part_file.h"
#include "compare/truth/ground_truth.h"
#include "compare/truth/point_truth.h"
#include "phase/stack/builtin_stacks.h"
#include "phase/stack/stack_file.h"
#include "volume/mesh/triangle_mesh.h"
#include "volume/result/number_bytes.h"
#include "volume/result/run_bytes.h"
#include "volume/run/saved_walks.h"
#include "volume/voxels/vdb_file.h"

namespace lamella {
namespace {

// A file in memory, for readers that take a path.
class MemoryFile {
 public:
  explicit MemoryFile(const std::string& bytes) : file_(memfd_create("input", 0)) {
    if (file_ < 0 || write(file_, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size()))
      throw std::logic_error("no file in memory");
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  ~MemoryFile() { close(file_); }
  [[nodiscard]] std::string path() const { return fmt::format("/proc/self/fd/{}", file_); }
  [[nodiscard]] std::string bytes() const {
    std::ifstream in(path(), std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }

 private:
  int file_;
};

template <class Refusal, class Read>
bool taken(const Read& read) {
  try {
    read();
    return true;
  } catch (const Refusal&) {
    return false;
  }
}

// What a writer of files writes: it takes the place of its file, so that it needs a folder.
template <class Write>
std::string written(const std::string& name, const Write& write) {
  const auto folder =
      std::filesystem::temp_directory_path() / fmt::format("lamella-fuzz-{}-{}", getpid(), name);
  std::filesystem::create_directories(folder);
  write(folder / name);
  std::ifstream in(folder / name, std::ios::binary);
  std::string bytes(std::istreambuf_iterator<char>(in), {});
  in.close();
  std::filesystem::remove_all(folder);
  return bytes;
}

const Plan& small_plan(const Stack& stack) {
  static const Plan plan = plan_of({.stack = stack});
  return plan;
}

Simulation& small_walks() {
  static const Stack stack = load_stack("isotropic_slab");
  static Simulation simulation(stack, small_plan(stack), {0, 0, 1}, Estimator::analog,
                               {.mu_cells = 1, .phi_cells = 2}, 1);
  if (simulation.walks() == 0) simulation.advance(kBatches);
  return simulation;
}

// What was accepted must read back the same.
bool read_stack(const std::string& bytes) {
  std::string toml;
  if (!taken<StackFileError>([&] { toml = to_toml(parse_stack(bytes, "fuzz.toml", "fuzz")); }))
    return false;
  if (to_toml(parse_stack(toml, "again.toml", "fuzz")) != toml)
    throw std::logic_error("reads back differently:\n" + toml);
  return true;
}

bool read_csv(const std::string& bytes) {
  return taken<UsageError>([&] {
    std::istringstream in(bytes);
    (void)read_pairs(in, "fuzz.csv");
  });
}

// Pixels of pictures that take this much at most: readers refuse beyond a gigabyte.
constexpr std::int64_t kMostPixels = std::int64_t{1} << 22;

bool read_exr_file(const std::string& bytes) {
  const MemoryFile file(bytes);
  return taken<OutputError>([&] {
    const std::vector<ExrPart> parts = read_exr_parts(file.path());
    (void)channels_text(parts);
    for (const ExrPart& part : parts)
      if (part.data.width() > kMostPixels || part.data.height() > kMostPixels ||
          part.data.width() * part.data.height() * static_cast<std::int64_t>(part.channels.size()) >
              kMostPixels)
        return;
    for (const ExrColors& colors : find_colors(parts))
      (void)read_exr_part(file.path(), colors.part, colors.channels);
    (void)read_exr(file.path());
    (void)read_lobes(file.path());
  });
}

bool read_png_bytes(const std::string& bytes) {
  return taken<OutputError>([&] { (void)read_png(bytes, "fuzz.png"); });
}

bool read_jpeg_bytes(const std::string& bytes) {
  return taken<OutputError>([&] { (void)read_jpeg(bytes, "fuzz.jpg"); });
}

bool read_obj_file(const std::string& bytes) {
  const MemoryFile file(bytes);
  return taken<MeshError>([&] { (void)read_obj(file.path()); });
}

std::string from_digits(std::string_view digits) {
  std::string bytes;
  for (std::size_t k = 0; k + 1 < digits.size(); k += 2)
    bytes += static_cast<char>(std::stoi(std::string(digits.substr(k, 2)), nullptr, 16));
  return bytes;
}

// 3 x 3 pixels of 8 bits in colour, 3 x 2 of 16 bits in grey.
std::vector<std::string> png_seeds() {
  return {from_digits(
              "89504e470d0a1a0a0000000d4948445200000003000000030802000000d94a22e8000000244944415478"
              "9c636060e09463e0b461e06460d0e094d3e0b4d100b20238e502386d0238011f0802c8f6825a34000000"
              "0049454e44ae426082"),
          from_digits(
              "89504e470d0a1a0a0000000d4948445200000003000000021000000000e88fe585000000164944415478"
              "9c636060607ec17e81818191f925fb450013a903884ad2cabb0000000049454e44ae426082")};
}

// 8 x 8 pixels, grey.
std::vector<std::string> jpeg_seeds() {
  return {from_digits(
      "ffd8ffe000104a46494600010100000100010000ffdb0043000302020302020303030304030304050805"
      "050404050a070706080c0a0c0c0b0a0b0b0d0e12100d0e110e0b0b1016101113141515150c0f17181614"
      "1812141514ffc0000b080008000801011100ffc40014000100000000000000000000000000000000ffc4"
      "0014100100000000000000000000000000000000ffda0008010100003f003fffd9")};
}

std::vector<std::string> obj_seeds() {
  return {"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 4//1 -2\n"};
}

bool read_vdb_file(const std::string& bytes) {
  const MemoryFile file(bytes);
  return taken<GridFileError>([&] { (void)read_vdb(file.path()); });
}

bool read_part_bytes(const std::string& bytes) {
  const MemoryFile file(bytes);
  return taken<UsageError>([&] {
    const PartFile part(file.path());
    (void)part.text("version");
    (void)part.all(std::uint64_t{1} << 20);
  });
}

bool read_part(const std::string& bytes) {
  if (bytes.size() > 65) {
    std::string right = bytes.substr(0, bytes.size() - 65);
    right += content_hash(right) + "\n";
    (void)read_part_bytes(right);
  }
  return read_part_bytes(bytes);
}

bool read_walks(const std::string& bytes) {
  std::vector<bool> there;
  return taken<DamagedBytes>([&] { (void)restore_walks(bytes, small_walks(), there); });
}

bool read_run(const std::string& bytes) {
  return taken<DamagedBytes>([&] { (void)run_from_bytes(bytes); });
}

bool read_values(const std::string& bytes) {
  return taken<DamagedBytes>([&] { (void)truth_values_from(bytes, 2); });
}

bool read_tensor(const std::string& bytes) {
  (void)taken<FormatError>([&] { (void)read_tensor_file(bytes, "fuzz.bsdf"); });
  return taken<FormatError>([&] {
    const auto model = read_brdf(bytes, "fuzz.bsdf");
    (void)model->eval({0, 0.6, 0.8}, {0.6, 0, 0.8});
  });
}

// A file of the right size that repeats the input after the sizes.
bool read_merl(const std::string& bytes) {
  const bool small = taken<FormatError>([&] { (void)read_brdf(bytes, "fuzz.binary"); });
  if (bytes.size() < 20) return small;
  std::string whole = bytes.substr(0, 12);
  while (whole.size() < 34992012)
    whole.append(bytes, 12, std::min<std::size_t>(bytes.size() - 12, 34992012 - whole.size()));
  return taken<FormatError>([&] {
    const auto model = read_brdf(whole, "fuzz.binary");
    (void)model->eval({0, 0.6, 0.8}, {0.6, 0, 0.8});
  });
}

bool read_npz_bytes(const std::string& bytes) {
  return taken<FormatError>([&] { (void)reference_of_npz(bytes, "fuzz.npz"); });
}

// The same with the right checksum of every member whose sizes lie within the file.
bool read_archive(const std::string& bytes) {
  std::string right = bytes;
  for (std::size_t at = 0; at + 30 < right.size() && right.compare(at, 4, "PK\x03\x04") == 0;) {
    std::uint32_t size = 0;
    std::uint16_t name = 0, more = 0;
    std::memcpy(&size, &right[at + 18], 4);
    std::memcpy(&name, &right[at + 26], 2);
    std::memcpy(&more, &right[at + 28], 2);
    const std::size_t from = at + 30 + name + more;
    if (from > right.size() || size > right.size() - from) break;
    const std::uint32_t sum = checksum(std::string_view(right).substr(from, size));
    std::memcpy(&right[at + 14], &sum, 4);
    at = from + size;
  }
  (void)read_npz_bytes(right);
  return read_npz_bytes(bytes);
}

bool read_index_text(const std::string& bytes) {
  return taken<UsageError>([&] { (void)to_text(index_from(bytes, "index.json")); });
}

bool read_settings(const std::string& bytes) {
  return taken<UsageError>(
      [&] { (void)options_from(nlohmann::ordered_json::parse(bytes, nullptr, false), "fuzz"); });
}

bool read_model(const std::string& bytes) {
  // Names of shared objects would be loaded.
  if (bytes.find('/') != std::string::npos || bytes.find(".so") != std::string::npos) return false;
  return taken<UsageError>([&] { check_request(parse_model_request(bytes)); });
}

std::vector<std::string> stack_seeds() {
  std::vector<std::string> seeds;
  for (const BuiltinStack& stack : builtin_stacks()) seeds.push_back(stack.toml);
  return seeds;
}

LobeSet small_lobes() {
  std::vector<RunResult> runs{reduce(small_walks())};
  LobeSet set = take_lobes(runs);
  set.attributes["lamella.stack"] = "x";
  return set;
}

std::vector<std::string> exr_seeds() {
  return {written("a.exr", [](const std::filesystem::path& path) {
    write_exr(path,
              simulation_image({.stack = load_stack("isotropic_slab")}, {reduce(small_walks())}));
  })};
}

std::vector<std::string> vdb_seeds() {
  if (!has_openvdb()) return {std::string("VDB")};
  return {written("a.vdb", [](const std::filesystem::path& path) {
    Voxels voxels(VoxelExtent{{9, 8, 8}});
    voxels.density.set({1, 1, 1}, {0.5F});
    write_vdb(path.string(), voxels, {0.1, 0.1, 0.1});
  })};
}

std::vector<std::string> part_seeds() {
  return {written("a.part", [](const std::filesystem::path& path) {
    write_part(path, {{{"version", LAMELLA_VERSION}, {"part", {1, 2}}},
                      {{0, "a"}, {3, std::string(100, 'b')}}});
  })};
}

std::vector<std::string> tensor_seeds() {
  TensorField theta, text;
  theta.name = "theta_i";
  theta.shape = {2};
  theta.numbers = {0, 1};
  text.name = "description";
  text.shape = {3};
  text.is_bytes = true;
  text.bytes = "abc";
  const BoundModel grey = bind_model(parse_model_request("lambert,albedo=0.5"), nullptr);
  const TensorSize size{.directions = 2, .density = 4, .table = 4};
  return {tensor_file({theta, text}), brdf_bytes(exported_model(grey), BrdfFormat::mitsuba, size),
          brdf_bytes(exported_model(grey), BrdfFormat::pbrt, size)};
}

std::vector<std::string> npz_seeds() {
  Reference reference;
  reference.set = small_lobes();
  reference.pairs = {{{0, 0, 1}, {0.6, 0, 0.8}}};
  reference.f = reference.f_error = {Rgb(0.1)};
  return {reference_npz(reference)};
}

std::vector<std::string> index_seeds() {
  LibraryEntry entry;
  entry.name = "a";
  entry.group = "hard";
  entry.lobes.name = entry.points.name = "analog";
  entry.lobes.walks = 7;
  entry.files = {{"a.npz", 1, "0"}};
  return {to_text(LibraryIndex{{entry}})};
}

std::vector<std::string> walk_seeds() {
  return {save_walks(small_walks(), 1, true), save_walks(small_walks(), 1, false)};
}

// What the solver finds: walks are kept as their batches.
std::vector<std::string> run_seeds() {
  GroundTruth truth({.stack = load_stack("isotropic_slab"),
                     .directions = {{0, 0, 1}},
                     .estimator = Estimator::deterministic,
                     .tolerance = 1e-2,
                     .cells = {.mu_cells = 1, .phi_cells = 2}},
                    Estimator::analog);
  return {to_bytes(truth.find(0).run)};
}

std::vector<std::string> value_seeds() { return {to_bytes(std::vector<TruthValue>(2))}; }

std::vector<std::string> csv_seeds() {
  return {"mu_i,phi_i,mu_o,phi_o\n0.5,0,0.8,90\n", "theta_i,phi_i,theta_o,phi_o\n60,0,30,1e2\n",
          "# note\r\nmu_i;phi_i;mu_o;phi_o\r\n0,5;0;0,8;90\r\n"};
}

std::vector<std::string> merl_seeds() {
  NumberWriter out;
  for (const std::int32_t n : {90, 90, 180}) out.put(n);
  for (const double v : {0.5, -1.0, 1e3}) out.put(v);
  return {out.take()};
}

std::vector<std::string> setting_seeds() { return {settings_json({}).dump()}; }

std::vector<std::string> model_seeds() {
  return {"eon,albedo=0.9,0.5,0.2,roughness=0.5", "coated,base=eon,base.albedo=0.5,ior=1.5"};
}

}  // namespace

const std::vector<InputReader>& input_readers() {
  static const std::vector<InputReader> list{
      {"stack", read_stack, stack_seeds, 5000},
      {"csv", read_csv, csv_seeds, 2000},
      {"exr", read_exr_file, exr_seeds, 100},
      {"png", read_png_bytes, png_seeds, 1000},
      {"jpeg", read_jpeg_bytes, jpeg_seeds, 1000},
      {"obj", read_obj_file, obj_seeds, 2000},
      {"vdb", read_vdb_file, vdb_seeds, 20},
      {"part", read_part, part_seeds, 500},
      {"walks", read_walks, walk_seeds, 500},
      {"run", read_run, run_seeds, 2000},
      {"values", read_values, value_seeds, 2000},
      {"tensor", read_tensor, tensor_seeds, 2000},
      {"merl", read_merl, merl_seeds, 3},
      {"npz", read_archive, npz_seeds, 1000},
      {"index", read_index_text, index_seeds, 1000},
      {"settings", read_settings, setting_seeds, 1000},
      {"model", read_model, model_seeds, 1000},
  };
  return list;
}

}  // namespace lamella
