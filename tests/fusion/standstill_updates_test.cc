#include "fusion/start/standstill_updates.h"

#include <gtest/gtest.h>

#include <vector>

#include "fusion/moving_state.h"

namespace cairn::fusion {
namespace {

using testing::kCloneStepNs;
using testing::MovingState;

constexpr int64_t kShakeStepNs = 5'000'000;
constexpr int kNumFeatures = 20;

// Samples from a second before the first clone to the newest one; those from `shakes_from_ns` on
// are not quiet.
ImuBuffer Samples(const FilterState& state, int64_t shakes_from_ns) {
  ImuBuffer buffer(1024);
  int i = 0;
  for (int64_t t = -1'000'000'000; t <= state.clones().back().timestamp_ns; t += kShakeStepNs) {
    const double shake = t >= shakes_from_ns && i++ % 2 == 0 ? 0.5 : 0.0;
    buffer.Push({t, {shake, 0.0, 0.0}, {0.0, 0.0, 9.81 + shake}});
  }
  return buffer;
}
constexpr int64_t kNever = INT64_MAX;

// Features that move by `pixels_per_frame`.
TrackTable Tracks(const FilterState& state, double pixels_per_frame) {
  const Camera camera(CameraModel::kPinhole, 640, 480, {460.0, 460.0, 320.0, 240.0});
  TrackTable tracks(64);
  for (const Clone& clone : state.clones()) {
    std::vector<TrackedFeature> features;
    for (uint64_t id = 0; id < kNumFeatures; ++id) {
      features.push_back({id,
                          {100.0 + 20.0 * static_cast<double>(id) +
                               pixels_per_frame * static_cast<double>(clone.frame_id),
                           200.0}});
    }
    tracks.AddFrame(clone.frame_id, camera, features);
  }
  return tracks;
}

TEST(StandstillUpdates, ADeviceAtRestLosesItsVelocity) {
  FilterState state = MovingState(3, 0.02, 0.05);
  StandstillUpdates updates({});
  const auto update = updates.Update(Samples(state, kNever), Tracks(state, 0.0), &state);
  EXPECT_TRUE(update.is_still);
  EXPECT_FALSE(update.redundant_frame_id.has_value());  // The one before is where it came to rest.
  EXPECT_LT(state.imu().velocity_in_local.norm(), 0.005);
}

TEST(StandstillUpdates, FramesAfterTheOneItCameToRestInAreRedundant) {
  FilterState state = MovingState(3, 0.0);
  StandstillUpdates updates({});
  ASSERT_TRUE(updates.Update(Samples(state, kNever), Tracks(state, 0.0), &state).is_still);
  state.AddClone(4, 3 * kCloneStepNs, Eigen::Vector3d::Zero());
  const auto update = updates.Update(Samples(state, kNever), Tracks(state, 0.0), &state);
  EXPECT_TRUE(update.is_still);
  EXPECT_EQ(update.redundant_frame_id, 3);  // It rests since 2.
}

TEST(StandstillUpdates, ACloneThatHasLeftIsReplacedByTheLastOne) {
  FilterState state = MovingState(3, 0.0);
  StandstillUpdates updates({});
  ASSERT_TRUE(updates.Update(Samples(state, kNever), Tracks(state, 0.0), &state).is_still);
  state.RemoveClone(1);  // Frame 2.
  state.AddClone(4, 3 * kCloneStepNs, Eigen::Vector3d::Zero());
  const auto update = updates.Update(Samples(state, kNever), Tracks(state, 0.0), &state);
  EXPECT_TRUE(update.is_still);
  EXPECT_FALSE(update.redundant_frame_id.has_value());
}

TEST(StandstillUpdates, ReadingsOfAMotionAreNoRest) {
  FilterState state = MovingState(3, 0.0);
  StandstillUpdates updates({});
  EXPECT_FALSE(updates.Update(Samples(state, 0), Tracks(state, 0.0), &state).is_still);
}

TEST(StandstillUpdates, TracksThatMoveAreNoRest) {
  FilterState state = MovingState(3, 0.0);
  StandstillUpdates updates({});
  EXPECT_FALSE(updates.Update(Samples(state, kNever), Tracks(state, 5.0), &state).is_still);
}

TEST(StandstillUpdates, WhatTheStateContradictsIsNoRest) {
  FilterState state = MovingState(3, 1.0);  // Known to a centimeter a second.
  StandstillUpdates updates({});
  EXPECT_FALSE(updates.Update(Samples(state, kNever), Tracks(state, 0.0), &state).is_still);
  EXPECT_NEAR(state.imu().velocity_in_local.y(), 1.0, 1e-9);
}

}  // namespace
}  // namespace cairn::fusion
