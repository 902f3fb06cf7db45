#include "mapping/growth/align_segments.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "mapping/street_views.h"
#include "support/street_photos.h"

namespace cairn {
namespace {

constexpr int kFirstOfB = 9;

struct TwoParts {
  Reconstruction street;
  PhotoSet set;
  Sim3d b_from_a = {3.0, Eigen::Quaterniond(0.8, 0.2, -0.5, 0.3).normalized(), {4.0, -7.0, 2.0}};

  TwoParts() {
    testing::StreetWorldOptions options;
    options.length_m = 34.0;
    options.keyframe_step_m = 2.0;
    options.num_landmarks = 500;
    street = testing::StreetWorld(options).Reconstruct();
    set = testing::PhotosOf(street);
  }

  // A third of the matches between the parts are wrong.
  TrackTable Tracks() const {
    std::vector<TwoView> views = testing::TrueViews(street, 15);
    for (TwoView& view : views) {
      for (size_t i = 3; (view.a < kFirstOfB) != (view.b < kFirstOfB) && i < view.inliers.size();
           i += 3) {
        std::swap(view.inliers[i].b_idx, view.inliers[i - 3].b_idx);
      }
    }
    return TrackTable(set, views);
  }

  Segment Part(const TrackTable& tracks, int first, int end, const Sim3d& part_from_world) const {
    Draft draft(set, tracks, street.cameras, 1);
    std::vector<int> photos(end - first);
    std::iota(photos.begin(), photos.end(), first);
    for (const int photo : photos) {
      draft.Add(photo, CamFromTarget(street.images[photo].cam_from_world, part_from_world));
    }
    draft.Triangulate(photos);
    return draft.Finish();
  }
};

TEST(AlignSegments, FindsTheSimilarityAmongWrongTracks) {
  const TwoParts parts;
  const TrackTable tracks = parts.Tracks();
  const Segment a = parts.Part(tracks, 0, kFirstOfB, {});
  const Segment b =
      parts.Part(tracks, kFirstOfB, static_cast<int>(parts.set.photos.size()), parts.b_from_a);
  const auto alignment = AlignSegments(tracks, a, b, 10, 1);
  ASSERT_TRUE(alignment);
  EXPECT_GT(alignment->num_agreeing, 20);
  EXPECT_LT(alignment->num_agreeing, alignment->num_shared);
  EXPECT_NEAR(alignment->b_from_a.scale / parts.b_from_a.scale, 1.0, 0.01);
  EXPECT_LT(RotationAngleRad(alignment->b_from_a.rotation, parts.b_from_a.rotation), 0.003);
  // The middle of the street; world b has 0.6 units a meter.
  const Eigen::Vector3d middle_in_a =
      parts.street.images[kFirstOfB].cam_from_world.Inverse().translation;
  EXPECT_LT((alignment->b_from_a * middle_in_a - parts.b_from_a * middle_in_a).norm(), 0.6 * 0.05);
}

TEST(AlignSegments, FewTracksAreNothing) {
  const TwoParts parts;
  const TrackTable tracks = parts.Tracks();
  const Segment a = parts.Part(tracks, 0, kFirstOfB, {});
  const Segment b =
      parts.Part(tracks, kFirstOfB, static_cast<int>(parts.set.photos.size()), parts.b_from_a);
  EXPECT_FALSE(AlignSegments(tracks, a, b, 5000, 1));
}

}  // namespace
}  // namespace cairn
