#include "fusion/map_updates/observation_ledger.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "fusion/filter/camera_view.h"
#include "fusion/moving_state.h"

namespace cairn::fusion {
namespace {

constexpr int kNumClones = 4;
constexpr int64_t kQueriedFrame = 3;
constexpr uint64_t kTrack = 17;
constexpr uint64_t kLandmark = 5;
constexpr double kSigmaPx = 1.0;

// Four clones, one point ahead that all of them see in one track; local is global.
class ObservationLedgerTest : public ::testing::Test {
 protected:
  ObservationLedgerTest()
      : camera_(CameraModel::kPinhole, 640, 480, {460.0, 460.0, 320.0, 240.0}),
        state_(testing::MovingState(kNumClones, 1.0)),
        tracks_(16),
        ledger_(camera_, kSigmaPx) {
    for (const Clone& clone : state_.clones()) {
      const auto seen = PredictPixel(camera_, CameraView(state_.rig(), clone), x_);
      pixels_.push_back(seen.value().pixel);
      tracks_.AddFrame(clone.frame_id, camera_, std::vector<TrackedFeature>{{kTrack, seen->pixel}});
    }
    tracks_.SetReserved(kQueriedFrame, true);
  }

  void Align() { testing::AlignAt(Rigid3d(), &state_); }

  MapMatch Match(double sigma_m) const {
    return {pixels_[kQueriedFrame - 1], kTrack, x_, sigma_m, kLandmark, 2};
  }
  LedgerObservations ObservationsOf(const MapMatch& match) const {
    return ledger_.ObservationsOf(std::vector<MapMatch>{match}, kQueriedFrame, state_, tracks_);
  }
  void Use(const LedgerObservations& observations) {
    ledger_.TakeOut(observations, std::vector<bool>(observations.observations.size(), true), state_,
                    &tracks_);
  }
  size_t NumLeft() const { return tracks_.Find(kTrack)->observations.size(); }

  const Eigen::Vector3d x_{8.0, 0.5, 0.2};
  Camera camera_;
  FilterState state_;
  TrackTable tracks_;
  ObservationLedger ledger_;
  std::vector<Eigen::Vector2d> pixels_;  // Of the clones.
};

TEST_F(ObservationLedgerTest, AMatchWithoutATrackIsOneObservation) {
  Align();
  MapMatch match = Match(0.01);
  match.track_id.reset();
  const LedgerObservations observations = ObservationsOf(match);
  ASSERT_EQ(observations.observations.size(), 1u);
  EXPECT_EQ(observations.observations[0].clone, kQueriedFrame - 1);
  EXPECT_EQ(observations.observations[0].pixel, match.pixel);
  Use(observations);
  EXPECT_EQ(NumLeft(), 4u);
}

TEST_F(ObservationLedgerTest, AKnownLandmarkTakesTheFreeObservationsOfItsTrack) {
  Align();
  tracks_.SetReserved(1, true);
  const LedgerObservations observations = ObservationsOf(Match(0.001));
  ASSERT_EQ(observations.observations.size(), 3u);  // The queried frame, 2 and 4.
  EXPECT_EQ(observations.observations[0].clone, 2);
  EXPECT_EQ(observations.observations[1].clone, 1);
  EXPECT_EQ(observations.observations[2].clone, 3);
  EXPECT_EQ(observations.observations[1].pixel, pixels_[1]);
  // Together they say no more of the landmark than the map does: a use takes nine tenths.
  EXPECT_NEAR(observations.observations[0].sigma_m, 0.001 * std::sqrt(3.0 / 0.9), 1e-12);
  Use(observations);
  ASSERT_EQ(NumLeft(), 1u);
  EXPECT_EQ(tracks_.Find(kTrack)->observations[0].frame_id, 1);
  EXPECT_FALSE(tracks_.Find(kTrack)->map_distance.has_value());
}

TEST_F(ObservationLedgerTest, AnUncertainLandmarkTakesTheQueriedObservationAndLeavesItsDistance) {
  Align();
  const LedgerObservations observations = ObservationsOf(Match(0.5));
  ASSERT_EQ(observations.observations.size(), 1u);
  Use(observations);
  EXPECT_EQ(NumLeft(), 3u);
  const auto& distance = tracks_.Find(kTrack)->map_distance;
  ASSERT_TRUE(distance.has_value());
  EXPECT_EQ(distance->x_in_global, x_);
  const Eigen::Vector3d ray = x_ - state_.clones()[kQueriedFrame - 1].local_from_imu.translation;
  EXPECT_LT((distance->direction_in_global - ray.normalized()).norm(), 1e-9);
}

TEST_F(ObservationLedgerTest, BeforeTheAlignmentOnlyTheQueriedObservationIsTaken) {
  EXPECT_EQ(ObservationsOf(Match(0.001)).observations.size(), 1u);
}

TEST_F(ObservationLedgerTest, WhatHasBeenUsedGivesNothing) {
  Align();
  Use(ObservationsOf(Match(0.001)));
  EXPECT_TRUE(ObservationsOf(Match(0.001)).observations.empty());
}

TEST_F(ObservationLedgerTest, OnlyUsedObservationsAreTakenOut) {
  Align();
  const LedgerObservations observations = ObservationsOf(Match(0.001));
  ASSERT_EQ(observations.observations.size(), 4u);
  ledger_.TakeOut(observations, {true, false, true, false}, state_, &tracks_);
  EXPECT_EQ(NumLeft(), 2u);
}

TEST_F(ObservationLedgerTest, ALandmarkTellsLessEachTimeUntilItIsForgotten) {
  Align();
  MapMatch match = Match(0.01);
  match.track_id.reset();
  const double first_sigma_m = ObservationsOf(match).observations[0].sigma_m;
  Use(ObservationsOf(match));
  EXPECT_GT(ObservationsOf(match).observations[0].sigma_m, 3.0 * first_sigma_m);
  ledger_.ForgetLandmarks(0.0);
  EXPECT_NEAR(ObservationsOf(match).observations[0].sigma_m, first_sigma_m, 1e-9);
  Use(ObservationsOf(match));
  ledger_.Clear();
  EXPECT_NEAR(ObservationsOf(match).observations[0].sigma_m, first_sigma_m, 1e-12);
}

}  // namespace
}  // namespace cairn::fusion
