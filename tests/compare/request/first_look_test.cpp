#include "compare/request/first_look.h"

#include <gtest/gtest.h>

namespace lamella {
namespace {

TEST(FirstLook, GivesRunsThatNothingWasAskedOfAShareOfItsTime) {
  FirstLook look({}, 4);
  EXPECT_TRUE(look.has_clock());
  const StopRule first = look.next();
  EXPECT_EQ(first.walks, StopRule{}.walks);
  EXPECT_NEAR(*first.seconds, kFirstLookSeconds / 4, 0.1);
  // What the first has left is shared by the three to come.
  EXPECT_NEAR(*look.next().seconds, kFirstLookSeconds / 3, 0.1);
  (void)look.next();
  EXPECT_NEAR(*look.next().seconds, kFirstLookSeconds, 0.1);
}

TEST(FirstLook, LeavesWhatWasAskedForAlone) {
  TruthRequest request;
  request.effort.walks = 5000;
  EXPECT_FALSE(FirstLook(request, 1).has_clock());
  request = {};
  request.given = {WalkSetting::walks};
  EXPECT_FALSE(FirstLook(request, 1).has_clock());
  request = {};
  request.effort.target_error = 0.01;
  EXPECT_FALSE(FirstLook(request, 1).next().seconds);
  request = {};
  request.effort.seconds = 3;
  FirstLook timed(request, 2);
  EXPECT_FALSE(timed.has_clock());
  EXPECT_EQ(timed.next().seconds, 3);
  EXPECT_EQ(timed.next().seconds, 3);
  // An order limit says nothing of the effort.
  request = {};
  request.given = {WalkSetting::max_order};
  EXPECT_TRUE(FirstLook(request, 1).has_clock());
}

}  // namespace
}  // namespace lamella
