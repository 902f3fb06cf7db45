#include "core/wire/accept.h"

#include <gtest/gtest.h>

namespace cairn {
namespace {

bool PrefersX(std::string_view accept) {
  return Prefers(accept, "application/x", "application/json");
}

TEST(Accept, ATypeMustBeNamed) {
  EXPECT_TRUE(PrefersX("application/x"));
  EXPECT_TRUE(PrefersX("text/html, APPLICATION/X;version=2.0;"));
  EXPECT_FALSE(PrefersX(""));
  EXPECT_FALSE(PrefersX("*/*"));
  EXPECT_FALSE(PrefersX("application/*"));
  EXPECT_FALSE(PrefersX("application/xml"));
}

TEST(Accept, TheLargerWeightWins) {
  EXPECT_FALSE(PrefersX("application/x;q=0"));
  EXPECT_FALSE(PrefersX("application/x; Q=0.000"));
  EXPECT_FALSE(PrefersX("application/json, application/x;q=0.5"));
  EXPECT_FALSE(PrefersX("application/x;q=0.5, */*"));
  EXPECT_TRUE(PrefersX("application/json;q=0.4, application/x;q=0.5"));
  EXPECT_TRUE(PrefersX("*/*;q=0.1, application/x;q=0.5"));
  EXPECT_TRUE(PrefersX("application/*;q=0.1, */*, application/x;q=0.5"));
}

TEST(Accept, AmongEqualWeightsTheFirstWins) {
  EXPECT_TRUE(PrefersX("application/x, application/json"));
  EXPECT_FALSE(PrefersX("application/json, application/x"));
  EXPECT_TRUE(PrefersX("*/*, application/x"));
}

}  // namespace
}  // namespace cairn
