// Parts of a set that grew apart become one if all their photos together say where they meet.
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "mapping/growth/grow_segments.h"
#include "mapping/pairs/find_pairs.h"
#include "mapping/street_views.h"
#include "support/street_photos.h"

namespace cairn {
namespace {

constexpr int kFirstOfSecondHalf = 13;

Reconstruction SparseStreet(double step_m = 2.0, int num_landmarks = 400) {
  testing::StreetWorldOptions options;
  options.length_m = 50.0;
  options.keyframe_step_m = step_m;
  options.num_landmarks = num_landmarks;
  options.clutter_ratio = 0.0;
  return testing::StreetWorld(options).Reconstruct();
}

// Of the landmarks that photos of both halves see, only each fifth is matched: no photo of a half
// sees 20 landmarks of the other.
bool IsMatchedInHalves(int a, int b, int landmark) {
  return (a < kFirstOfSecondHalf) == (b < kFirstOfSecondHalf) || landmark % 5 == 0;
}

Growth Grow(const PhotoSet& set, std::vector<TwoView> views, int num_threads = 1) {
  GrowthOptions options;
  options.num_threads = num_threads;
  return GrowSegments(set, views, options);
}

Growth GrowHalves(const Reconstruction& street, int num_threads = 1) {
  return Grow(testing::PhotosOf(street), testing::TrueViews(street, 15, IsMatchedInHalves),
              num_threads);
}

double WorstErrorOf(const Reconstruction& street, const Segment& segment) {
  return testing::WorstError(street, segment.model, segment.photo_of_image);
}

TEST(JoinSegments, HalvesWithWeakLinksMeet) {
  const Reconstruction street = SparseStreet();
  const Growth growth = GrowHalves(street);
  ASSERT_EQ(growth.segments.size(), 1u);
  EXPECT_EQ(growth.segments[0].photo_of_image.size(), street.images.size());
  EXPECT_NO_THROW(growth.segments[0].model.Validate());
  const Growth whole = Grow(testing::PhotosOf(street), testing::TrueViews(street, 15));
  ASSERT_EQ(whole.segments.size(), 1u);
  EXPECT_LT(WorstErrorOf(street, growth.segments[0]),
            2.0 * WorstErrorOf(street, whole.segments[0]));
  EXPECT_TRUE(
      std::all_of(growth.verdict_of_photo.begin(), growth.verdict_of_photo.end(),
                  [](PhotoVerdict verdict) { return verdict == PhotoVerdict::kInSegment; }));
}

// The halves share no landmark that two photos of each see: most landmarks are those of one half,
// and of the second, its neighbor in the first half sees many; that of the first, too few to join
// it.
TEST(JoinSegments, PhotosOnTheBorderTellWhereHalvesMeet) {
  const Reconstruction street = SparseStreet(2.0, 1200);
  constexpr int kLastOfFirst = kFirstOfSecondHalf - 1;
  const auto is_matched = [](int a, int b, int landmark) {
    const bool is_of_both = landmark % 16 == 0, is_of_second = landmark % 3 == 0;
    return is_of_both     ? std::max(a, b) <= kFirstOfSecondHalf
           : is_of_second ? std::min(a, b) >= kLastOfFirst
                          : std::max(a, b) <= kLastOfFirst;
  };
  const Growth growth = Grow(testing::PhotosOf(street), testing::TrueViews(street, 8, is_matched));
  ASSERT_EQ(growth.segments.size(), 1u);
  EXPECT_EQ(growth.segments[0].photo_of_image.size(), street.images.size());
  EXPECT_LT(WorstErrorOf(street, growth.segments[0]), 0.2 * 0.3);
}

// The links of one photo to the other half are wrong, a third of all. Where positions tell where
// both halves are, the other links join them; without positions, nothing would contradict a wrong
// union.
TEST(JoinSegments, DoubtfulLinksNeedPositions) {
  const Reconstruction street = SparseStreet();
  std::vector<TwoView> views = testing::TrueViews(street, 10, IsMatchedInHalves);
  size_t num_right = 0, num_wrong = 0;
  for (TwoView& view : views) {
    if (view.a >= kFirstOfSecondHalf || view.b < kFirstOfSecondHalf) {
      continue;
    }
    const bool is_wrong = view.a == kFirstOfSecondHalf - 1;
    (is_wrong ? num_wrong : num_right) += view.inliers.size();
    for (size_t i = 1; is_wrong && i < view.inliers.size(); ++i) {
      std::swap(view.inliers[i].b_idx, view.inliers[i - 1].b_idx);
    }
  }
  EXPECT_GT(num_right, 2 * num_wrong);
  EXPECT_LT(num_right, 4 * num_wrong);
  PhotoSet set = testing::PhotosOf(street);
  EXPECT_EQ(Grow(set, views).segments.size(), 2u);
  testing::AddNoisyPositions(street, 1.0, 2.0, 9, &set);
  const Growth growth = Grow(set, views);
  ASSERT_EQ(growth.segments.size(), 1u);
  EXPECT_LT(WorstErrorOf(street, growth.segments[0]), 0.2 * 0.3);
}

TEST(JoinSegments, OrderOfPhotosDoesNotMatter) {
  Reconstruction street = SparseStreet();
  const int last = static_cast<int>(street.images.size()) - 1;
  std::reverse(street.images.begin(), street.images.end());
  for (ReconLandmark& landmark : street.landmarks) {
    for (ReconObservation& seen : landmark.observations) {
      seen.image_idx = last - seen.image_idx;
    }
  }
  const Growth growth = Grow(testing::PhotosOf(street),
                             testing::TrueViews(street, 15, [&](int a, int b, int landmark) {
                               return IsMatchedInHalves(last - a, last - b, landmark);
                             }));
  ASSERT_EQ(growth.segments.size(), 1u);
  EXPECT_EQ(growth.segments[0].photo_of_image.size(), street.images.size());
  EXPECT_LT(WorstErrorOf(street, growth.segments[0]), 0.2 * 0.08);
}

TEST(JoinSegments, ThreadsDoNotMatter) {
  const Reconstruction street = SparseStreet();
  const Growth one = GrowHalves(street, 1), three = GrowHalves(street, 3);
  ASSERT_EQ(one.segments.size(), 1u);
  ASSERT_EQ(three.segments.size(), 1u);
  ASSERT_EQ(one.segments[0].photo_of_image, three.segments[0].photo_of_image);
  for (size_t i = 0; i < one.segments[0].model.images.size(); ++i) {
    EXPECT_EQ(one.segments[0].model.images[i].cam_from_world.ToMatrix(),
              three.segments[0].model.images[i].cam_from_world.ToMatrix());
  }
}

// A part of a few photos moves to one of more than 200, which stays; and parts in a row all meet.
TEST(JoinSegments, PartsOfALongStreetMeet) {
  testing::StreetWorldOptions options;
  options.length_m = 480.0;
  options.keyframe_step_m = 2.0;
  options.num_landmarks = 2860;
  options.clutter_ratio = 0.0;
  const Reconstruction street = testing::StreetWorld(options).Reconstruct();
  const auto part_of = [](int photo) { return photo < 205 ? 0 : (photo - 193) / 12; };
  const std::vector<TwoView> views = testing::TrueViews(
      street, 15,
      [&](int a, int b, int landmark) { return part_of(a) == part_of(b) || landmark % 5 == 0; });
  const Growth growth = Grow(testing::PhotosOf(street), views, 2);
  ASSERT_EQ(growth.segments.size(), 1u);
  EXPECT_EQ(growth.segments[0].photo_of_image.size(), street.images.size());
  EXPECT_LT(WorstErrorOf(street, growth.segments[0]), 2e-3 * 480.0 * 0.2);
}

// Photos of a facade match those of its copy as if they were taken from the same places, but only a
// twentieth of what they show does. Nothing contradicts that; photos from one place share more.
TEST(JoinSegments, WeakLinksToACopyJoinNothing) {
  const Reconstruction street = SparseStreet(1.0, 1000);
  const auto is_copy = [](int photo) { return photo % 2 == 1; };
  const std::vector<TwoView> views = testing::TrueViews(
      street, 10,
      [&](int a, int b, int landmark) { return is_copy(a) == is_copy(b) || landmark % 20 == 0; });
  EXPECT_GT(std::count_if(views.begin(), views.end(),
                          [&](const TwoView& view) { return is_copy(view.a) != is_copy(view.b); }),
            20);
  const Growth growth = Grow(testing::PhotosOf(street), views);
  ASSERT_EQ(growth.segments.size(), 2u);
  for (const Segment& segment : growth.segments) {
    EXPECT_TRUE(std::all_of(
        segment.photo_of_image.begin(), segment.photo_of_image.end(),
        [&](int photo) { return is_copy(photo) == is_copy(segment.photo_of_image[0]); }));
  }
}

// Half of what the photos show repeats every 30 m, so the links are strong, and parts are so small
// that a few positions fit any place. Parts may stay apart, but none may be lost or be wrong.
TEST(JoinSegments, PositionsKeepCopiesApart) {
  testing::StreetWorldOptions options;
  options.length_m = 60.0;
  options.keyframe_step_m = 2.0;
  options.num_landmarks = 1500;
  options.repeat_period_m = 30.0;
  options.unique_ratio = 0.5;
  options.seed = 4;
  options.max_view_distance_m = 24.0;
  const Reconstruction street = testing::StreetWorld(options).Reconstruct();
  PhotoSet set = testing::PhotosOf(street);
  testing::AddNoisyPositions(street, 3.3, 5.0, 9, &set);
  const Growth growth = Grow(set, FindTwoViews(set, FindPairs(set, {}), {}));
  size_t num_photos = 0;
  for (const Segment& segment : growth.segments) {
    num_photos += segment.photo_of_image.size();
    EXPECT_LT(WorstErrorOf(street, segment), 0.2 * 1.0);
  }
  EXPECT_GE(num_photos, 30u);
}

}  // namespace
}  // namespace cairn
