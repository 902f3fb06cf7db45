#include "engine/voting/vote_ray.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/angles.h"
#include "engine/query/level_frame.h"

namespace cairn {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// A level camera looking along x, one keypoint with the ray `direction_in_level`.
QueryContext MakeQuery(const Vector3d& direction_in_level) {
  QueryContext query;
  query.down_in_cam = Vector3d::UnitY();
  query.level_from_cam = LevelFromCam(Vector3d::UnitY());
  query.keypoints.resize(1);
  query.keypoints[0].scale_px = 5.0f;
  query.rays_in_cam = {query.level_from_cam->conjugate() * direction_in_level.normalized()};
  query.region.radius_m = 1000.0;
  return query;
}

Correspondence MakeMatch(const Vector3d& x_in_anchor) {
  Correspondence match;
  match.x_in_anchor = x_in_anchor;
  match.azimuth_rad = static_cast<float>(kPi);
  return match;
}

TEST(MakeVoteRays, TurnsRayIntoLevelFrame) {
  const Vector3d direction = Vector3d(3, 1, 2).normalized();
  const auto rays = MakeVoteRays(MakeQuery(direction), {MakeMatch({10, 0, 5})}, VotingOptions());
  ASSERT_THAT(rays, SizeIs(1));
  EXPECT_TRUE(rays[0].direction_in_level.isApprox(direction, 1e-9));
  EXPECT_NEAR(rays[0].horizontal, std::hypot(direction.x(), direction.y()), 1e-12);
  EXPECT_TRUE(rays[0].view_azimuth.isApprox(Vector2d(-1, 0), 1e-6));
}

TEST(MakeVoteRays, ClipsToTheHeightBand) {
  // Rising at 45 degrees to a landmark at height 12; cameras stand between 0 and 2.
  QueryContext query = MakeQuery({1, 0, 1});
  query.region.min_z_m = 0.0;
  query.region.max_z_m = 2.0;
  const auto rays = MakeVoteRays(query, {MakeMatch({10, 0, 12})}, VotingOptions());
  ASSERT_THAT(rays, SizeIs(1));
  EXPECT_NEAR(rays[0].min_distance_m, 10.0 * std::sqrt(2.0), 1e-9);
  EXPECT_NEAR(rays[0].max_distance_m, 12.0 * std::sqrt(2.0), 1e-9);
  // The same landmark below the horizon cannot be seen from below.
  QueryContext downward = MakeQuery({1, 0, -1});
  downward.region = query.region;
  EXPECT_THAT(MakeVoteRays(downward, {MakeMatch({10, 0, 12})}, VotingOptions()), IsEmpty());
}

TEST(MakeVoteRays, HorizontalRayNeedsLandmarkInTheHeightBand) {
  QueryContext query = MakeQuery({1, 0, 0});
  query.region.min_z_m = 0.0;
  query.region.max_z_m = 2.0;
  EXPECT_THAT(MakeVoteRays(query, {MakeMatch({10, 0, 1})}, VotingOptions()), SizeIs(1));
  EXPECT_THAT(MakeVoteRays(query, {MakeMatch({10, 0, 3})}, VotingOptions()), IsEmpty());
}

TEST(MakeVoteRays, SizeOfKeypointBoundsTheDistance) {
  // 5 px at a focal length of 500 are 0.01 rad: 0.2 m stand 20 m off.
  Correspondence match = MakeMatch({10, 0, 1});
  match.size_m = 0.2f;
  VotingOptions options;
  options.max_distance_factor = 2.0;
  auto rays = MakeVoteRays(MakeQuery({1, 0, 0}), {match}, options);
  ASSERT_THAT(rays, SizeIs(1));
  EXPECT_NEAR(rays[0].min_distance_m, 10.0, 1e-5);
  EXPECT_NEAR(rays[0].max_distance_m, 40.0, 1e-5);
  options.max_distance_factor = 0.0;
  rays = MakeVoteRays(MakeQuery({1, 0, 0}), {match}, options);
  EXPECT_EQ(rays[0].max_distance_m, options.max_distance_m);
  match.size_m = 0.0f;  // Unknown.
  options.max_distance_factor = 2.0;
  rays = MakeVoteRays(MakeQuery({1, 0, 0}), {match}, options);
  EXPECT_EQ(rays[0].max_distance_m, options.max_distance_m);
}

TEST(MakeVoteRays, SkipsKeypointsWithoutRayAndSortsByKeypoint) {
  QueryContext query = MakeQuery({1, 0, 0});
  query.keypoints.resize(3);
  query.rays_in_cam = {query.rays_in_cam[0], Vector3d::Zero(), query.rays_in_cam[0]};
  std::vector<Correspondence> matches(3, MakeMatch({10, 0, 1}));
  matches[0].keypoint_idx = 2;
  matches[1].keypoint_idx = 1;
  matches[2].keypoint_idx = 0;
  const auto rays = MakeVoteRays(query, matches, VotingOptions());
  ASSERT_THAT(rays, SizeIs(2));
  EXPECT_EQ(rays[0].correspondence_idx, 2);
  EXPECT_EQ(rays[1].correspondence_idx, 0);
}

}  // namespace
}  // namespace cairn
