// Growth of a segment that is too large to be adjusted as a whole each time.
#include <gtest/gtest.h>

#include "mapping/growth/grow_segments.h"
#include "mapping/street_views.h"
#include "support/street_photos.h"

namespace cairn {
namespace {

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
  const Growth growth =
      GrowSegments(testing::PhotosOf(street), testing::TrueViews(street, 20), growth_options);
  ASSERT_EQ(growth.segments.size(), 1u);
  const Segment& segment = growth.segments[0];
  EXPECT_EQ(segment.model.images.size(), street.images.size());
  // The world has a scale of 0.2. Two thousandths of a street that is open at both ends, and that
  // no position holds.
  EXPECT_LT(testing::WorstError(street, segment.model, segment.photo_of_image), 2e-3 * 540.0 * 0.2);
}

}  // namespace
}  // namespace cairn
