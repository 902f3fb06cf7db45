#include "mapping/pairs/find_pairs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "support/expect_error.h"
#include "support/street_photos.h"

namespace cairn {
namespace {

PairOptions Few() {
  PairOptions options;
  options.max_exhaustive = 0;
  options.max_partners = 6;
  return options;
}

// Photos every 3 cm, which show much the same.
Reconstruction OneWall(int num_photos) {
  testing::StreetWorldOptions options;
  options.length_m = 0.03 * (num_photos - 1);
  options.keyframe_step_m = 0.03;
  options.num_landmarks = 300;
  return testing::StreetWorld(options).Reconstruct();
}

// Of each pair of photos that shares any.
std::map<std::pair<int, int>, int> SharedLandmarks(const Reconstruction& street) {
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
  return shared;
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
  auto shared = SharedLandmarks(street);
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

// Photos of one wall choose among a part of each other, and all of them have partners with which
// they share much.
TEST(FindPairs, OfManyPhotosOfOnePlaceAPanelIsAsked) {
  const PhotoSet set = testing::PhotosOf(OneWall(150));
  PairOptions options = Few();
  options.max_panel = 30;
  const auto pairs = FindPairs(set, options);
  EXPECT_LE(pairs.size(), 150u * 6u);
  std::vector<int> num_partners(150, 0), num_chosen(150, 0);
  for (const auto& [a, b] : pairs) {
    ++num_partners[a];
    ++num_partners[b];
  }
  EXPECT_GE(*std::min_element(num_partners.begin(), num_partners.end()), 6);
  // Those of the panel are in all pairs, so that the pairs of the others meet.
  std::vector<int> order = num_partners;
  std::sort(order.rbegin(), order.rend());
  EXPECT_LT(order[30], 12) << "more than 30 photos were asked";
}

// Photos of other places than the panel's ask on, until they find partners that show the same.
TEST(FindPairs, WhoIsNotServedByAPanelAsksTheOthers) {
  testing::StreetWorldOptions options;
  options.length_m = 160.0;
  options.num_landmarks = 3000;
  options.keyframe_step_m = 4.0;
  const Reconstruction street = testing::StreetWorld(options).Reconstruct();
  PairOptions pair_options = Few();
  pair_options.max_panel = 20;
  const auto shared = SharedLandmarks(street);
  std::vector<int> num_good(street.images.size(), 0);
  for (const auto& pair : FindPairs(testing::PhotosOf(street), pair_options)) {
    const auto found = shared.find(pair);
    if (found != shared.end() && found->second >= 50) {
      ++num_good[pair.first];
      ++num_good[pair.second];
    }
  }
  EXPECT_GE(*std::min_element(num_good.begin(), num_good.end()), 4);
}

TEST(FindPairs, TakesDescriptorsOfTheShippedCodebookAlone) {
  PhotoSet set;
  set.cameras.emplace_back();
  set.photos.resize(2);
  set.photos[1].name = "b.jpg";
  set.photos[1].keypoints.resize(3);
  const auto expect_refused = [&](const std::string& text) {
    testing::ExpectError([&] { FindPairs(set, {}); }, ErrorCode::kBadInput, text);
  };
  set.photos[1].descriptors = ByteDescriptorMatrix(3, 64);
  expect_refused("photo b.jpg has 64-D descriptors of type 'sift'");
  set.photos[1].descriptors = ByteDescriptorMatrix(3, 128);
  EXPECT_EQ(FindPairs(set, {}).size(), 1u);
  set.descriptor_type = "orb";
  expect_refused("photo b.jpg has 128-D descriptors of type 'orb'");
}

TEST(FindPairs, PhotosWithoutFeaturesHaveNoPartners) {
  PhotoSet set = testing::PhotosOf(testing::StreetWorld().Reconstruct());
  set.photos[3].keypoints.clear();
  set.photos[3].descriptors = ByteDescriptorMatrix(0, 128);
  for (const auto& [a, b] : FindPairs(set, Few())) {
    EXPECT_TRUE(a != 3 && b != 3);
  }
}

}  // namespace
}  // namespace cairn
