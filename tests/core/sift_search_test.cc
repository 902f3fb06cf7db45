// Tests the search for SIFT features octave by octave.
#include "core/features/sift/sift_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>

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
    ASSERT_EQ(features.size(), expected.size());
    EXPECT_EQ(features.descriptors, expected.descriptors);
    for (int i = 0; i < features.size(); ++i) {
      EXPECT_TRUE(AreEqual(features.keypoints[i], expected.keypoints[i])) << i;
    }
  }
}

}  // namespace
}  // namespace cairn
