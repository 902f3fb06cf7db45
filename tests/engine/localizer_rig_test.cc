// Tests queries of several cameras that are mounted to each other.
#include <gtest/gtest.h>

#include <set>

#include "core/angles.h"
#include "core/error.h"
#include "engine/mapped_streets.h"

namespace cairn {
namespace {

using testing::ExpectPose;
using testing::QueryAt;
using testing::QueryPose;
using testing::StreetWorld;

class LocalizerRig : public testing::OneStreetTest {};

// The query with every n-th of its features, from the first on.
void KeepEvery(int n, LocalizeQuery* query) {
  FeatureSet& features = query->features;
  const int kept = (features.size() + n - 1) / n;
  for (int i = 0; i < kept; ++i) {
    features.keypoints[i] = features.keypoints[n * i];
    features.descriptors.row(i) = features.descriptors.row(n * i);
  }
  features.keypoints.resize(kept);
  features.descriptors.conservativeResize(kept, Eigen::NoChange);
}

// A rig of three cameras that see so little that none of them is localized alone.
LocalizeQuery PoorRigQuery(const StreetWorld& world, const Rigid3d& cam_from_enu) {
  constexpr int kThinning = 115;
  LocalizeQuery query = QueryAt(world, cam_from_enu);
  KeepEvery(kThinning, &query);
  for (const double azimuth_rad : {-0.5, 0.9}) {
    const Rigid3d own_from_enu = StreetWorld::LookAlong(
        cam_from_enu.Inverse().translation + Eigen::Vector3d(0.8, azimuth_rad, 0.2), azimuth_rad);
    LocalizeQuery own = QueryAt(world, own_from_enu);
    KeepEvery(kThinning, &own);
    query.other_cameras.push_back(
        {world.camera(), own_from_enu * cam_from_enu.Inverse(), own.features});
  }
  return query;
}

TEST_F(LocalizerRig, LocalizesARigOfWhichNoCameraIsLocalizedAlone) {
  const Rigid3d cam_from_enu = QueryPose(20.0);
  for (const bool has_gravity : {true, false}) {
    LocalizeQuery rig = PoorRigQuery(*world_, cam_from_enu);
    LocalizeQuery alone = rig;
    alone.other_cameras.clear();
    EXPECT_FALSE(localizer().Localize(alone).localized);
    if (!has_gravity) {
      rig.down_in_cam.reset();
    }
    const LocalizeResult result = localizer().Localize(rig);
    ExpectPose(result, *world_, cam_from_enu, 0.1, 0.2 * kRadPerDeg);
    EXPECT_EQ(result.counters.num_keypoints, rig.num_features());
    std::set<int> cameras;
    for (const LocalizeMatch& match : result.matches) {
      cameras.insert(match.camera_idx);
      const FeatureSet& features =
          match.camera_idx == 0 ? rig.features : rig.other_cameras[match.camera_idx - 1].features;
      ASSERT_LT(match.keypoint_idx, features.size());
      EXPECT_EQ(match.pixel.x(), features.keypoints[match.keypoint_idx].x_px);
    }
    EXPECT_EQ(cameras.size(), 3u);
  }
}

TEST_F(LocalizerRig, TheFirstCameraOfARigMaySeeNothing) {
  const Rigid3d cam_from_enu = QueryPose(20.0);
  LocalizeQuery rig = QueryAt(*world_, cam_from_enu);
  const Rigid3d own_from_first(ExpSo3({0.0, 0.4, 0.1}), {0.5, 0.0, -1.0});
  rig.other_cameras.push_back(
      {world_->camera(), own_from_first, QueryAt(*world_, own_from_first * cam_from_enu).features});
  rig.features = FeatureSet();
  ExpectPose(localizer().Localize(rig), *world_, cam_from_enu, 0.1, 0.2 * kRadPerDeg);
}

TEST_F(LocalizerRig, RefusesRigsThatMakeNoSense) {
  LocalizeQuery query = PoorRigQuery(*world_, QueryPose(20.0));
  query.other_cameras[1].cam_from_first.translation.x() = 1000.0;
  EXPECT_THROW(localizer().Localize(query), Error);
  query = PoorRigQuery(*world_, QueryPose(20.0));
  query.other_cameras[0].features.space = DescriptorSpace::kProjected;
  EXPECT_THROW(localizer().Localize(query), Error);
  query = PoorRigQuery(*world_, QueryPose(20.0));
  query.other_cameras.resize(RigCamera::kMaxOthers + 1);
  EXPECT_THROW(localizer().Localize(query), Error);
}

}  // namespace
}  // namespace cairn
