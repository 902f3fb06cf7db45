// Growth of a segment that is too large to be adjusted as a whole each time.
#include <gtest/gtest.h>

#include <map>
#include <vector>

#include "mapping/growth/grow_segments.h"
#include "support/street_photos.h"

namespace cairn {
namespace {

// The relative poses of photos that follow each other, as matching would find them without errors.
std::vector<TwoView> TrueViews(const Reconstruction& street) {
  constexpr int kFarthest = 6;
  std::map<std::pair<int, int>, std::vector<FeatureMatch>> matches;
  for (const ReconLandmark& landmark : street.landmarks) {
    for (const ReconObservation& p : landmark.observations) {
      for (const ReconObservation& q : landmark.observations) {
        if (p.image_idx < q.image_idx && q.image_idx <= p.image_idx + kFarthest) {
          matches[{p.image_idx, q.image_idx}].push_back({p.keypoint_idx, q.keypoint_idx, 0.1f});
        }
      }
    }
  }
  std::vector<TwoView> views;
  for (auto& [pair, inliers] : matches) {
    if (inliers.size() < 20) {
      continue;
    }
    TwoView view;
    view.a = pair.first;
    view.b = pair.second;
    view.b_from_a =
        street.images[view.b].cam_from_world * street.images[view.a].cam_from_world.Inverse();
    view.b_from_a.translation.normalize();
    view.inliers = std::move(inliers);
    view.parallax_rad = 0.05;
    view.rotation_sigma_rad = 0.002;
    view.direction_sigma_rad = 0.01;
    views.push_back(std::move(view));
  }
  return views;
}

TEST(GrowLongStreet, AdjustedWhereItGrowsIsOneSegment) {
  testing::StreetWorldOptions options;
  options.length_m = 540.0;
  options.keyframe_step_m = 2.0;
  options.num_landmarks = 2000;
  options.clutter_ratio = 0.0;
  const Reconstruction street = testing::StreetWorld(options).Reconstruct();
  ASSERT_GT(street.images.size(), 260u);
  GrowthOptions growth_options;
  growth_options.num_threads = 2;
  const Growth growth = GrowSegments(testing::PhotosOf(street), TrueViews(street), growth_options);
  ASSERT_EQ(growth.segments.size(), 1u);
  const Segment& segment = growth.segments[0];
  EXPECT_EQ(segment.model.images.size(), street.images.size());
  // The world has a scale of 0.2. Two thousandths of a street that is open at both ends, and that
  // no position holds.
  EXPECT_LT(testing::WorstError(street, segment.model, segment.photo_of_image), 2e-3 * 540.0 * 0.2);
}

}  // namespace
}  // namespace cairn
