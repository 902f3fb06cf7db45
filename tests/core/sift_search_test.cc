// Tests the search for SIFT features octave by octave.
#include "core/features/sift/sift_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/error.h"

namespace cairn {
namespace {

// Rectangles of many sizes and grays, so that all octaves have features.
GrayImage Rectangles(int width_px, int height_px) {
  GrayImage image = BlankImage(width_px, height_px);
  uint32_t state = 7;
  const auto next = [&](int below) {
    state = state * 1664525u + 1013904223u;
    return static_cast<int>((state >> 8) % static_cast<uint32_t>(below));
  };
  for (int i = 0; i < 1200; ++i) {
    const int side = 3 + (i % 7 == 0 ? 60 : 12);
    const int left = next(width_px), top = next(height_px);
    const int right = std::min(width_px, left + 2 + next(side));
    const int bottom = std::min(height_px, top + 2 + next(side));
    const auto gray = static_cast<uint8_t>(30 + next(200));
    for (int y = top; y < bottom; ++y) {
      for (int x = left; x < right; ++x) {
        image.pixels[static_cast<size_t>(y) * width_px + x] = gray;
      }
    }
  }
  return image;
}

bool AreEqual(const Keypoint& a, const Keypoint& b) {
  return a.x_px == b.x_px && a.y_px == b.y_px && a.scale_px == b.scale_px &&
         a.orientation_rad == b.orientation_rad;
}

TEST(SiftSearch, OctavesAddUpToTheFeaturesOfTheImage) {
  const GrayImage image = Rectangles(400, 300);
  for (const int max_features : {100, 2500}) {
    const SiftOptions options{.max_features = max_features};
    const FeatureSet expected = ExtractSift(image, options);
    SiftSearch search(image, options);
    FeatureSet features;
    int num_steps = 0;
    for (float last_scale_px = 1e9f; !search.is_done(); ++num_steps) {
      const int num_before = features.size();
      search.AddNextOctave(&features);
      // From the coarsest on; octaves overlap by half of their width.
      ASSERT_GT(features.size(), num_before);
      EXPECT_LT(features.keypoints[num_before].scale_px, 1.1f * last_scale_px);
      last_scale_px = features.keypoints[num_before].scale_px;
    }
    EXPECT_GT(num_steps, 2);
    EXPECT_EQ(search.num_features(), features.size());
    ASSERT_EQ(features.size(), expected.size());
    EXPECT_EQ(features.descriptors, expected.descriptors);
    for (int i = 0; i < features.size(); ++i) {
      EXPECT_TRUE(AreEqual(features.keypoints[i], expected.keypoints[i])) << i;
    }
  }
}

TEST(SiftSearch, AddsOnlyWhatIsExpected) {
  const GrayImage image = Rectangles(400, 300);
  const FeatureSet all = ExtractSift(image);
  SiftSearch search(image, {});
  FeatureSet features;
  search.AddNextOctave(&features);
  const int num_coarse = features.size();
  // Every fifth of the fine features, and places where none has this scale.
  std::vector<ExpectedFeature> expected;
  for (int i = num_coarse; i < all.size(); i += 5) {
    const Keypoint& keypoint = all.keypoints[i];
    expected.push_back({keypoint.x_px, keypoint.y_px, 0.01f, 0.99f * keypoint.scale_px,
                        1.01f * keypoint.scale_px});
    expected.push_back({keypoint.x_px, keypoint.y_px, 100.0f, 900.0f, 1000.0f});
  }
  search.AddExpected(expected, &features);
  EXPECT_TRUE(search.is_done());
  const int num_expected = static_cast<int>(expected.size()) / 2;
  EXPECT_GT(num_expected, 50);
  EXPECT_LT(features.size() - num_coarse, 2 * num_expected);  // A place may have two orientations.
  int num_found = 0;
  for (int i = num_coarse; i < all.size(); i += 5) {
    for (int k = num_coarse; k < features.size(); ++k) {
      if (AreEqual(features.keypoints[k], all.keypoints[i])) {
        EXPECT_EQ(features.descriptors.row(k), all.descriptors.row(i));
        ++num_found;
        break;
      }
    }
  }
  // Those of the doubled image are not sought.
  EXPECT_GT(num_found, 0.5 * num_expected);
}

TEST(SiftSearch, ExpectsNothingOutsideThePicture) {
  const GrayImage image = Rectangles(64, 48);
  SiftSearch search(image, {});
  FeatureSet features;
  const std::vector<ExpectedFeature> expected = {{-500.0f, 20.0f, 3.0f, 0.1f, 50.0f},
                                                 {1e7f, -1e7f, 3.0f, 0.1f, 50.0f}};
  search.AddExpected(expected, &features);
  EXPECT_EQ(features.size(), 0);
  EXPECT_TRUE(search.is_done());
}

TEST(SiftSearch, SkipsOctavesThatWereSearchedAlready) {
  const GrayImage image = Rectangles(400, 300);
  SiftSearch search(image, {});
  FeatureSet features;
  search.SkipOctavesFrom(2.0);
  search.AddNextOctave(&features);
  ASSERT_GT(features.size(), 0);
  for (const Keypoint& keypoint : features.keypoints) {
    EXPECT_LT(keypoint.scale_px, 4.5f);  // 1.6 pixels, an octave and half a level.
  }
}

}  // namespace
}  // namespace cairn
