#include "mapping/pairs/find_pairs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "support/street_photos.h"

namespace cairn {
namespace {

PairOptions Few() {
  PairOptions options;
  options.max_exhaustive = 0;
  options.max_partners = 6;
  return options;
}

TEST(FindPairs, MatchesSmallSetsCompletely) {
  PhotoSet set;
  set.cameras.emplace_back();
  set.photos.resize(5);
  EXPECT_EQ(FindPairs(set, {}).size(), 10u);
}

TEST(FindPairs, PrefersPhotosThatShareMost) {
  const Reconstruction street = testing::StreetWorld().Reconstruct();
  const auto pairs = FindPairs(testing::PhotosOf(street), Few());
  std::map<std::pair<int, int>, int> shared;
  for (const ReconLandmark& landmark : street.landmarks) {
    for (const ReconObservation& a : landmark.observations) {
      for (const ReconObservation& b : landmark.observations) {
        if (a.image_idx < b.image_idx) {
          ++shared[{a.image_idx, b.image_idx}];
        }
      }
    }
  }
  // Each photo's best partner is among its choices.
  for (int photo = 0; photo < static_cast<int>(street.images.size()); ++photo) {
    std::pair<int, int> best;
    for (const auto& [pair, count] : shared) {
      if ((pair.first == photo || pair.second == photo) && count > shared[best]) {
        best = pair;
      }
    }
    EXPECT_TRUE(std::binary_search(pairs.begin(), pairs.end(), best)) << best.first << best.second;
  }
  EXPECT_LE(pairs.size(), 21u * 6u);
}

TEST(FindPairs, DoesNotDependOnThreads) {
  const PhotoSet set = testing::PhotosOf(testing::StreetWorld().Reconstruct());
  PairOptions options = Few();
  const auto one = FindPairs(set, options);
  options.num_threads = 3;
  EXPECT_EQ(FindPairs(set, options), one);
}

TEST(FindPairs, PositionsKeepPhotosOfDistantPlacesApart) {
  PhotoSet set = testing::PhotosOf(testing::StreetWorld().Reconstruct());
  const int half = static_cast<int>(set.photos.size()) / 2;
  for (int i = 0; i < static_cast<int>(set.photos.size()); ++i) {
    set.photos[i].gps = Geodetic::FromDegrees(i < half ? 47.0 : 47.01, 8.0, 400.0);
  }
  for (const auto& [a, b] : FindPairs(set, Few())) {
    EXPECT_EQ(a < half, b < half) << a << " and " << b << " are 1 km apart";
  }
}

TEST(FindPairs, PhotosWithoutFeaturesHaveNoPartners) {
  PhotoSet set = testing::PhotosOf(testing::StreetWorld().Reconstruct());
  set.photos[3].keypoints.clear();
  set.photos[3].descriptors.resize(0, 128);
  for (const auto& [a, b] : FindPairs(set, Few())) {
    EXPECT_TRUE(a != 3 && b != 3);
  }
}

}  // namespace
}  // namespace cairn
