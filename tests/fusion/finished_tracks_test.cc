#include "fusion/tracks/finished_tracks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

namespace cairn::fusion {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr int kMinViews = 2;
constexpr int kWindow = 16;

class FinishedTracks : public ::testing::Test {
 protected:
  // Frames 1 to `num_frames`, each with a clone; the track with id n is seen in the first
  // `num_observations[n]` of them.
  void See(int num_frames, const std::vector<int>& num_observations) {
    for (int frame = 1; frame <= num_frames; ++frame) {
      std::vector<TrackedFeature> features;
      for (size_t id = 0; id < num_observations.size(); ++id) {
        if (frame <= num_observations[id]) {
          features.push_back({id, {300.0 + frame, 200.0}});
        }
      }
      tracks_.AddFrame(frame, camera_, features);
      clones_.push_back({frame, frame * 100, {}, {}});
    }
  }

  std::vector<FinishedTrack> Take(int max_clones) {
    return TakeFinishedTracks(clones_, max_clones, kMinViews, &tracks_);
  }

  static std::vector<int64_t> FramesOf(const std::vector<Observation>& observations) {
    std::vector<int64_t> frame_ids;
    for (const Observation& observation : observations) {
      frame_ids.push_back(observation.frame_id);
    }
    return frame_ids;
  }
  std::vector<int64_t> FramesLeft(uint64_t id) { return FramesOf(tracks_.Find(id)->observations); }

  Camera camera_{CameraModel::kPinhole, 640, 480, {460.0, 460.0, 320.0, 240.0}};
  TrackTable tracks_{16};
  std::vector<Clone> clones_;
};

TEST_F(FinishedTracks, ATrackThatEndedIsTakenWhole) {
  See(4, {3, 4});
  const std::vector<FinishedTrack> finished = Take(kWindow);
  ASSERT_EQ(finished.size(), 1u);
  EXPECT_EQ(finished[0].track_id, 0u);
  EXPECT_FALSE(finished[0].goes_on);
  EXPECT_THAT(FramesOf(finished[0].observations), ElementsAre(1, 2, 3));
  EXPECT_THAT(FramesLeft(0), IsEmpty());
  EXPECT_THAT(FramesLeft(1), ElementsAre(1, 2, 3, 4));
}

TEST_F(FinishedTracks, ATrackThatGoesOnIsTakenWhenItsCloneLeavesTheWindow) {
  See(4, {4});
  EXPECT_THAT(Take(4), IsEmpty());
  const std::vector<FinishedTrack> finished = Take(3);
  ASSERT_EQ(finished.size(), 1u);
  EXPECT_TRUE(finished[0].goes_on);
  EXPECT_THAT(FramesOf(finished[0].observations), ElementsAre(1, 2, 3));
  EXPECT_THAT(FramesLeft(0), ElementsAre(4));  // Begins the next part.
}

TEST_F(FinishedTracks, ReservedObservationsStay) {
  See(4, {3, 4});
  tracks_.SetReserved(1, true);
  const std::vector<FinishedTrack> finished = Take(3);  // Frame 1 leaves, but waits for an answer.
  ASSERT_EQ(finished.size(), 1u);
  EXPECT_THAT(FramesOf(finished[0].observations), ElementsAre(2, 3));
  EXPECT_THAT(FramesLeft(0), ElementsAre(1));
  EXPECT_THAT(FramesLeft(1), ElementsAre(1, 2, 3, 4));
}

TEST_F(FinishedTracks, TooShortOnesAreLeftAlone) {
  See(4, {1, 4});
  EXPECT_THAT(Take(kWindow), IsEmpty());
  EXPECT_THAT(FramesLeft(0), ElementsAre(1));
}

TEST_F(FinishedTracks, TakeWhatTheMapSaysOfTheirDistance) {
  See(4, {3});
  tracks_.Find(0)->map_distance = MapDistance{{1.0, 2.0, 3.0}, {1.0, 0.0, 0.0}, 0.1, 9};
  const std::vector<FinishedTrack> finished = Take(kWindow);
  ASSERT_EQ(finished.size(), 1u);
  ASSERT_TRUE(finished[0].map_distance.has_value());
  EXPECT_EQ(finished[0].map_distance->tile_id, 9u);
  EXPECT_FALSE(tracks_.Find(0)->map_distance.has_value());
}

}  // namespace
}  // namespace cairn::fusion
