#include "compare/shards/shard.h"

#include <gtest/gtest.h>

#include <vector>

#include "compare/request/errors.h"

namespace lamella {
namespace {

TEST(Shard, PartsHaveEveryBatchOfEveryPieceOnce) {
  for (const std::uint64_t count : {1u, 2u, 3u, 7u, 17u, 100u, 128u, 129u, 1000u})
    for (std::uint64_t piece = 0; piece < 5; ++piece) {
      std::vector<int> times(kBatches);
      int owners = 0, most = 0;
      for (std::uint64_t k = 1; k <= count; ++k) {
        const Shard shard{k, count};
        const BatchRange range = shard.batches(piece);
        ASSERT_TRUE(range.first >= 0 && range.first <= range.end && range.end <= kBatches);
        for (int b = range.first; b < range.end; ++b) ++times[b];
        most = std::max(most, range.end - range.first);
        owners += shard.has(piece);
      }
      EXPECT_EQ(times, std::vector<int>(kBatches, 1)) << count << " parts, piece " << piece;
      EXPECT_EQ(owners, 1);
      EXPECT_LE(most, (kBatches - 1) / static_cast<int>(count) + 1);
    }
}

TEST(Shard, IsReadFromItsText) {
  EXPECT_EQ(parse_shard("2/4"), (Shard{2, 4}));
  EXPECT_EQ(parse_shard("1/1"), (Shard{}));
  EXPECT_EQ(parse_shard("3/17").text(), "3/17");
  for (const char* text : {"", "1", "/", "0/4", "5/4", "1/0", "-1/4", "1/4/2", "a/b", "1/2 x",
                           "1/1000001", "99999999999999999999/4"})
    EXPECT_THROW((void)parse_shard(text), UsageError) << text;
}

}  // namespace
}  // namespace lamella
