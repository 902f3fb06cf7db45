#include "mapping/growth/grow_segments.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "mapping/pairs/find_pairs.h"
#include "support/street_photos.h"

namespace cairn {
namespace {

testing::StreetWorldOptions SmallStreet() {
  testing::StreetWorldOptions options;
  options.length_m = 36.0;
  options.keyframe_step_m = 2.0;
  options.num_landmarks = 900;
  return options;
}

Growth Grow(const PhotoSet& set, int num_threads = 1) {
  TwoViewOptions view_options;
  view_options.num_threads = num_threads;
  GrowthOptions options;
  options.num_threads = num_threads;
  return GrowSegments(set, FindTwoViews(set, FindPairs(set, {}), view_options), options);
}

TEST(GrowSegments, MapsAStreetWithoutAnyPose) {
  const Reconstruction street = testing::StreetWorld(SmallStreet()).Reconstruct();
  const Growth growth = Grow(testing::PhotosOf(street));
  ASSERT_EQ(growth.segments.size(), 1u);
  const Segment& segment = growth.segments[0];
  EXPECT_EQ(segment.model.images.size(), street.images.size());
  EXPECT_NO_THROW(segment.model.Validate());
  // The world of the street has a scale of 0.2: 1 cm.
  EXPECT_LT(testing::WorstError(street, segment.model, segment.photo_of_image), 0.002 * 5);
  for (const PhotoVerdict verdict : growth.verdict_of_photo) {
    EXPECT_EQ(verdict, PhotoVerdict::kInSegment);
  }
}

TEST(GrowSegments, DoesNotDependOnThreads) {
  testing::StreetWorldOptions options = SmallStreet();
  options.length_m = 20.0;
  const PhotoSet set = testing::PhotosOf(testing::StreetWorld(options).Reconstruct());
  const Growth one = Grow(set, 1), three = Grow(set, 3);
  ASSERT_EQ(one.segments.size(), three.segments.size());
  for (size_t i = 0; i < one.segments.size(); ++i) {
    ASSERT_EQ(one.segments[i].photo_of_image, three.segments[i].photo_of_image);
    for (size_t k = 0; k < one.segments[i].model.images.size(); ++k) {
      EXPECT_EQ(one.segments[i].model.images[k].cam_from_world.ToMatrix(),
                three.segments[i].model.images[k].cam_from_world.ToMatrix());
    }
  }
}

TEST(GrowSegments, PhotosOfTwoPlacesBecomeTwoSegments) {
  testing::StreetWorldOptions here = SmallStreet(), there = SmallStreet();
  here.length_m = there.length_m = 20.0;
  there.seed = 77;
  const PhotoSet first = testing::PhotosOf(testing::StreetWorld(here).Reconstruct());
  PhotoSet set = first;
  for (MappingPhoto photo : testing::PhotosOf(testing::StreetWorld(there).Reconstruct()).photos) {
    photo.name = "there/" + photo.name;
    set.photos.push_back(std::move(photo));
  }
  const Growth growth = Grow(set);
  ASSERT_EQ(growth.segments.size(), 2u);
  for (const Segment& segment : growth.segments) {
    const bool is_first = segment.photo_of_image[0] < static_cast<int>(first.photos.size());
    for (const int photo : segment.photo_of_image) {
      EXPECT_EQ(photo < static_cast<int>(first.photos.size()), is_first);
    }
  }
}

// A street of which nine tenths repeat every 12 m: each photo shows several copies. Photos may be
// left out, but none may stand at another copy.
TEST(GrowSegments, PutsNoPhotoAtAnotherCopyOfAFacade) {
  for (const uint64_t seed : {1, 4}) {
    testing::StreetWorldOptions options = SmallStreet();
    options.repeat_period_m = 12.0;
    options.unique_ratio = 0.1;
    options.seed = seed;
    const Reconstruction street = testing::StreetWorld(options).Reconstruct();
    const Growth growth = Grow(testing::PhotosOf(street));
    EXPECT_FALSE(growth.segments.empty());
    for (const Segment& segment : growth.segments) {
      EXPECT_LT(testing::WorstError(street, segment.model, segment.photo_of_image), 0.2 * 1.0);
    }
  }
}

// No photo shows two copies, so that only the positions tell them apart.
TEST(GrowSegments, PositionsTellCopiesOfAFacadeApart) {
  testing::StreetWorldOptions options = SmallStreet();
  options.length_m = 48.0;
  options.repeat_period_m = 30.0;
  options.unique_ratio = 0.1;
  options.max_view_distance_m = 24.0;
  const Reconstruction street = testing::StreetWorld(options).Reconstruct();
  PhotoSet set = testing::PhotosOf(street);
  testing::AddNoisyPositions(street, 2.0, 3.0, 5, &set);
  const Growth growth = Grow(set);
  size_t num_photos = 0;
  for (const Segment& segment : growth.segments) {
    num_photos += segment.photo_of_image.size();
    EXPECT_LT(testing::WorstError(street, segment.model, segment.photo_of_image), 0.2 * 1.0);
  }
  EXPECT_GE(2 * num_photos, set.photos.size());
}

// A receiver in a street canyon: each fourth position is 40 m off, each in a direction of its own.
TEST(GrowSegments, PositionsThatAreFarOffCostNoPhoto) {
  const Reconstruction street = testing::StreetWorld(SmallStreet()).Reconstruct();
  PhotoSet set = testing::PhotosOf(street);
  testing::AddNoisyPositions(street, 1.0, 2.0, 5, &set);
  for (size_t i = 1; i < set.photos.size(); i += 4) {
    Geodetic& gps = *set.photos[i].gps;
    const double direction_rad = 2.0 * static_cast<double>(i);
    gps.lat_rad += 40.0 / 6.37e6 * std::sin(direction_rad);
    gps.lon_rad += 40.0 / (6.37e6 * std::cos(gps.lat_rad)) * std::cos(direction_rad);
  }
  const Growth growth = Grow(set);
  ASSERT_EQ(growth.segments.size(), 1u);
  EXPECT_EQ(growth.segments[0].photo_of_image.size(), set.photos.size());
  EXPECT_LT(
      testing::WorstError(street, growth.segments[0].model, growth.segments[0].photo_of_image),
      0.2 * 0.1);
}

TEST(GrowSegments, SaysWhyAPhotoIsNotInTheMap) {
  PhotoSet set = testing::PhotosOf(testing::StreetWorld(SmallStreet()).Reconstruct());
  set.photos[4].keypoints.clear();
  set.photos[4].descriptors = ByteDescriptorMatrix(0, 128);
  const Growth growth = Grow(set);
  EXPECT_EQ(growth.verdict_of_photo[4], PhotoVerdict::kNoTwoView);
  EXPECT_STREQ(ExplainVerdict(growth.verdict_of_photo[4]),
               "no other photo shows enough of what it shows");
}

TEST(GrowSegments, TwoPhotosAreNoSegment) {
  PhotoSet set = testing::PhotosOf(testing::StreetWorld(SmallStreet()).Reconstruct());
  set.photos.resize(2);
  EXPECT_TRUE(Grow(set).segments.empty());
  set.photos.clear();
  EXPECT_TRUE(Grow(set).segments.empty());
}

TEST(GrowSegments, ReportsTheIterationsOfItsAdjustments) {
  const PhotoSet set = testing::PhotosOf(testing::StreetWorld(SmallStreet()).Reconstruct());
  const std::vector<TwoView> views = FindTwoViews(set, FindPairs(set, {}), {});
  std::string steps;  // 'p' for photos, 'i' for iterations.
  GrowSegments(
      set, views, {}, [&](int, int) { steps += 'p'; },
      [&](int done, int most) {
        EXPECT_LE(done, most);
        steps += done > 0 ? "i" : "";
      });
  const size_t iteration = steps.find('i', steps.find('p'));
  ASSERT_NE(iteration, std::string::npos) << steps;
  EXPECT_NE(steps.find('p', iteration), std::string::npos) << steps;
  EXPECT_THROW(GrowSegments(set, views, {}, {}, [](int, int) { throw std::runtime_error("stop"); }),
               std::runtime_error);
}

// A guess that is a third off is adjusted: photos without EXIF.
TEST(GrowSegments, FindsAFocalLengthThatNobodyKnows) {
  const Reconstruction street = testing::StreetWorld(SmallStreet()).Reconstruct();
  PhotoSet set = testing::PhotosOf(street);
  const Camera& truth = street.cameras[0];
  Camera guess = CameraOfUnknownFocal(truth.width_px(), truth.height_px());
  set.cameras[0] = {guess, FocalPrior(), FocalSource::kGuess};
  const Growth growth = Grow(set);
  ASSERT_EQ(growth.segments.size(), 1u);
  EXPECT_EQ(growth.segments[0].model.images.size(), street.images.size());
  EXPECT_NEAR(growth.segments[0].model.cameras[0].focal_px() / truth.focal_px(), 1.0, 0.02);
}

}  // namespace
}  // namespace cairn
