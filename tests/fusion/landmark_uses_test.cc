#include "fusion/map_updates/landmark_uses.h"

#include <gtest/gtest.h>

namespace cairn::fusion {
namespace {

constexpr uint64_t kUsedLandmark = 7;

// Information that all uses together take, in units of what the map knows.
double Taken(int num_uses, double share_kept) {
  LandmarkUses uses;
  double taken = 0.0;
  for (int i = 0; i < num_uses; ++i) {
    uses.Forget(share_kept);
    taken = share_kept * taken + 1.0 / uses.VarianceFactor(kUsedLandmark);
    uses.Add(kUsedLandmark);
  }
  return taken;
}

TEST(LandmarkUses, AllUsesAtAnInstantSayNoMoreThanTheMapKnows) {
  EXPECT_NEAR(Taken(1, 1.0), 0.9, 1e-9);
  EXPECT_NEAR(Taken(2, 1.0), 0.99, 1e-9);
  EXPECT_LT(Taken(20, 1.0), 1.01);
}

TEST(LandmarkUses, WhatTheStateHasForgottenMayBeUsedAgain) {
  LandmarkUses uses;
  uses.Add(kUsedLandmark);
  EXPECT_NEAR(uses.VarianceFactor(kUsedLandmark), 1.0 / 0.09, 1e-9);
  uses.Forget(0.5);
  EXPECT_NEAR(uses.VarianceFactor(kUsedLandmark), 1.0 / (0.9 * 0.55), 1e-9);
  uses.Forget(0.0);
  EXPECT_NEAR(uses.VarianceFactor(kUsedLandmark), 1.0 / 0.9, 1e-6);
  EXPECT_LE(Taken(50, 0.7), 1.0);
  EXPECT_GT(Taken(50, 0.7), 0.9);
}

}  // namespace
}  // namespace cairn::fusion
