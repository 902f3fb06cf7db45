#include "core/evenly_of.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

namespace cairn {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(EvenlyOf, SpreadsOverTheList) {
  const std::vector<int> ten = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
  EXPECT_THAT(EvenlyOf(ten, 3), ElementsAre(0, 3, 6));
  EXPECT_THAT(EvenlyOf(ten, 9), ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8));
  EXPECT_EQ(EvenlyOf(ten, 10), ten);
  EXPECT_EQ(EvenlyOf(ten, 100), ten);
  EXPECT_THAT(EvenlyOf(ten, 0), IsEmpty());
  EXPECT_THAT(EvenlyOf(std::vector<int>(), 3), IsEmpty());
}

}  // namespace
}  // namespace cairn
