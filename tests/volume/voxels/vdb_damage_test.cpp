// Damaged .vdb files: one line of error, in bounded memory and time.
#include <gtest/gtest.h>
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <cstdlib>
#include <fstream>
#include <random>

#include "tests/volume/voxels/vdb_fixture.h"
#include "volume/voxels/vdb_file.h"

namespace lamella {
namespace {

using testing::expect_part;
using testing::grid_with;
using testing::VdbFile;

std::string bytes_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void write_bytes(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

constexpr std::uint32_t kCompressions[] = {
    openvdb::io::COMPRESS_NONE, openvdb::io::COMPRESS_ZIP,
    std::uint32_t{openvdb::io::COMPRESS_BLOSC} | openvdb::io::COMPRESS_ACTIVE_MASK};

// Two grids with leaves and tiles, values that do not compress away.
openvdb::GridCPtrVec two_grids() {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> uniform(0, 1);
  const auto density = openvdb::FloatGrid::create(0.25f);
  density->setName("density");
  density->fill(openvdb::CoordBBox({0, 0, 0}, {31, 31, 15}), 0.5f);
  const auto albedo = openvdb::Vec3SGrid::create(openvdb::Vec3s(1, 1, 1));
  albedo->setName("albedo");
  auto d = density->getAccessor();
  auto a = albedo->getAccessor();
  for (int x = 0; x < 24; ++x)
    for (int y = 0; y < 20; ++y)
      for (int z = 0; z < 12; ++z) {
        d.setValue({x, y, z}, uniform(random));
        a.setValue({x, y, z}, {uniform(random), uniform(random), 0.5f});
      }
  return {density, albedo};
}

void write_with(const std::string& path, const openvdb::GridCPtrVec& grids, std::uint32_t flags) {
  openvdb::io::File file(path);
  file.setCompression(flags);
  file.write(grids);
}

TEST_F(VdbFile, RefusesTruncatedFiles) {
  for (const std::uint32_t flags : kCompressions) {
    const openvdb::GridCPtrVec both = two_grids();
    for (const bool one : {false, true}) {
      write_with(file("whole.vdb"), one ? openvdb::GridCPtrVec{both[0]} : both, flags);
      const std::string bytes = bytes_of(file("whole.vdb"));
      EXPECT_EQ(refusal_of(file("whole.vdb")), "no refusal");
      for (const std::size_t missing : {std::size_t{1}, bytes.size() / 100, bytes.size() / 2,
                                        bytes.size() - 30, bytes.size() - 3, bytes.size()}) {
        write_bytes(file("cut.vdb"), bytes.substr(0, bytes.size() - missing));
        const std::string refusal = refusal_of(file("cut.vdb"));
        expect_part(refusal, {"cut.vdb", ".vdb file"});
        EXPECT_EQ(refusal.find('\n'), std::string::npos) << refusal;
        if (missing <= bytes.size() / 100)
          expect_part(refusal, {"no whole .vdb file", "ends at byte"});
      }
    }
  }
}

TEST_F(VdbFile, RefusesWhatIsNoRegularFile) {
  ASSERT_EQ(mkfifo(file("pipe.vdb").c_str(), 0600), 0);
  expect_part(refusal_of(file("pipe.vdb")), {"pipe.vdb", "no regular file"});
  expect_part(refusal_of("/dev/zero"), {"/dev/zero", "no regular file"});
}

TEST_F(VdbFile, ReadsFilesOfOneStreamAndGridsThatShareATree) {
  const auto density = grid_with<openvdb::FloatGrid>("density", 3);
  std::ofstream out(file("stream.vdb"), std::ios::binary);
  openvdb::io::Stream(out).write(openvdb::GridCPtrVec{density});
  out.close();
  EXPECT_EQ(read_vdb(file("stream.vdb")).voxels.density.at({0, 0, 0})[0], 3);
  const auto shared = density->copy();
  shared->setName("roughness");
  density->setName("roughness");
  shared->setName("density");
  shared->tree().setValue({1, 2, 3}, 0.5f);  // of both
  openvdb::io::File(file("shared.vdb")).write({density, shared});
  const Voxels voxels = read_vdb(file("shared.vdb")).voxels;
  EXPECT_EQ(voxels.density.at({0, 0, 0})[0], 0.5f);
  EXPECT_EQ(voxels.roughness->at({0, 0, 0})[0], 0.5f);
}

// Bytes changed, runs overwritten with ends of the number ranges, pieces cut out, doubled or moved.
std::string mutated(std::string bytes, std::mt19937& random) {
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random()) % n; };
  const std::size_t changes = 1 + below(6);
  // Half of the changes go to the first part, where names, sizes and places stand.
  const auto place = [&] {
    return below(random() % 2 ? std::min<std::size_t>(bytes.size(), 1500) : bytes.size());
  };
  for (std::size_t k = 0; k < changes && bytes.size() > 16; ++k) {
    const std::size_t at = place();
    const std::size_t length = std::min<std::size_t>(bytes.size() - at, 1 + below(16));
    switch (random() % 6) {
      case 0:
        bytes[at] = static_cast<char>(random());
        break;
      case 1:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << (random() % 8)));
        break;
      case 2:
        bytes.replace(at, length, length, random() % 2 ? '\xff' : '\0');
        break;
      case 3:
        bytes.replace(at, std::min<std::size_t>(length, 4), "\xff\xff\xff\x7f", 0,
                      std::min<std::size_t>(length, 4));
        break;
      case 4:
        bytes.erase(at, length);
        break;
      default:
        bytes.insert(at, bytes.substr(below(bytes.size()), length));
    }
  }
  return bytes;
}

TEST_F(VdbFile, EveryMutatedFileIsReadOrRefusedInOneLine) {
  std::vector<std::string> originals;
  for (const std::uint32_t flags : kCompressions) {
    write_with(file("whole.vdb"), two_grids(), flags);
    originals.push_back(bytes_of(file("whole.vdb")));
  }
  const int count = std::getenv("LAMELLA_SOAK") ? 10000 : 300;
  std::mt19937 random(20250101);
  int refused = 0;
  for (int k = 0; k < count; ++k) {
    write_bytes(file("mutated.vdb"), mutated(originals[k % originals.size()], random));
    try {
      // What is read has been checked value by value.
      (void)read_vdb(file("mutated.vdb"));
    } catch (const GridFileError& error) {
      ++refused;
      const std::string text = error.what();
      EXPECT_EQ(text.find('\n'), std::string::npos) << text;
      EXPECT_LT(text.size(), 1000u) << text;
      expect_part(text, {"mutated.vdb: "});
    }
  }
  // Some change voxels only.
  EXPECT_GT(refused, count / 4);
  EXPECT_LT(refused, count);
  rusage usage{};
  ASSERT_EQ(getrusage(RUSAGE_CHILDREN, &usage), 0);
#ifndef __SANITIZE_ADDRESS__
  EXPECT_LT(usage.ru_maxrss, 2 << 20);  // KiB: the limit is 1 GiB for files of this size
#endif
}

}  // namespace
}  // namespace lamella
