#include "core/scene/tracks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <utility>
#include <vector>

namespace cairn {
namespace {

using Track = std::vector<std::pair<int, int>>;  // (image, keypoint).

std::vector<Track> Tracks(const std::vector<PairMatches>& pairs,
                          const std::vector<int>& num_keypoints, int min_length) {
  std::vector<Track> tracks;
  for (const auto& observations : BuildTracks(pairs, num_keypoints, min_length)) {
    Track track;
    for (const ReconObservation& observation : observations) {
      track.emplace_back(observation.image_idx, observation.keypoint_idx);
    }
    tracks.push_back(std::move(track));
  }
  return tracks;
}

TEST(BuildTracks, JoinsMatchesAcrossImages) {
  const auto tracks = Tracks({{0, 1, {{4, 5, 1.0f}}}, {1, 2, {{5, 6, 1.0f}}}}, {9, 9, 9}, 2);
  EXPECT_THAT(tracks, ::testing::ElementsAre(Track{{0, 4}, {1, 5}, {2, 6}}));
}

TEST(BuildTracks, DropsShortOnes) {
  EXPECT_TRUE(Tracks({{0, 1, {{4, 5, 1.0f}}}}, {9, 9}, 3).empty());
}

TEST(BuildTracks, SplitsConflictsByTheWorstMatch) {
  // Keypoints 1 and 2 of image 0 would end up in one track; the match of image 1 and 2 is the
  // worst.
  const auto tracks = Tracks({{0, 1, {{1, 1, 1.0f}}},
                              {0, 2, {{2, 2, 2.0f}}},
                              {1, 2, {{1, 2, 9.0f}}},
                              {2, 3, {{2, 3, 3.0f}}}},
                             {3, 3, 3, 4}, 2);
  EXPECT_THAT(tracks, ::testing::UnorderedElementsAre(Track{{0, 1}, {1, 1}},
                                                      Track{{0, 2}, {2, 2}, {3, 3}}));
}

TEST(BuildTracks, KeepsTracksApartThatShareNoMatch) {
  const auto tracks = Tracks({{0, 1, {{0, 0, 1.0f}, {1, 1, 1.0f}}}}, {2, 2}, 2);
  EXPECT_THAT(tracks,
              ::testing::UnorderedElementsAre(Track{{0, 0}, {1, 0}}, Track{{0, 1}, {1, 1}}));
}

}  // namespace
}  // namespace cairn
