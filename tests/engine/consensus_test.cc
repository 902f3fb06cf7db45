#include "engine/pose/consensus.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "core/rigid3.h"

namespace cairn {
namespace {

using Eigen::Vector3d;

struct Scene {
  Rigid3d cam_from_anchor;
  std::vector<RayObservation> observations;
};

// Keypoints with 1 to 4 observations; about a third of the observations are near inliers.
Scene MakeScene(int num_keypoints, uint64_t seed, const Vector3d& origin = Vector3d::Zero()) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto vector = [&]() -> Vector3d {
    return {uniform(random), uniform(random), uniform(random)};
  };
  Scene scene;
  scene.cam_from_anchor =
      Rigid3d(ExpSo3(vector()), vector()) * Rigid3d(Eigen::Quaterniond::Identity(), -origin);
  for (int k = 0; k < num_keypoints; ++k) {
    const int num_observations = 1 + static_cast<int>(random() % 4);
    const Vector3d ray = (Vector3d::UnitZ() + 0.5 * vector()).normalized();
    for (int i = 0; i < num_observations; ++i) {
      const double kind = uniform(random);
      const Vector3d x_in_cam =
          kind > 0.3 ? Vector3d(20.0 * vector()) : Vector3d(15.0 * (ray + 0.01 * vector()));
      scene.observations.push_back({ray, scene.cam_from_anchor.Inverse() * x_in_cam,
                                    0.005 + 0.005 * std::abs(uniform(random)), i == 0 ? 0.0 : 0.05,
                                    k});
    }
  }
  return scene;
}

// The definition, in double precision.
double ReferenceGain(const RayObservation& observation, const Rigid3d& cam_from_anchor,
                     double extra_sq_rad) {
  const Vector3d x_in_cam = cam_from_anchor * observation.x_in_anchor;
  if (observation.ray_in_cam.dot(x_in_cam) <= 0.0) {
    return 0.0;
  }
  const double sine = observation.ray_in_cam.cross(x_in_cam.normalized()).norm();
  const double sq_base = observation.threshold_rad * observation.threshold_rad;
  const double landmark = 3.0 * observation.sigma_m / x_in_cam.norm();
  const double sq_threshold = std::min(sq_base + landmark * landmark, 4.0 * sq_base) + extra_sq_rad;
  return std::max(0.0, 1.0 - sine * sine / sq_threshold);
}

double ReferenceSum(const Scene& scene, double extra_sq_rad) {
  std::map<int, double> best;
  for (const RayObservation& observation : scene.observations) {
    double& entry = best[observation.keypoint_idx];
    entry = std::max(entry, ReferenceGain(observation, scene.cam_from_anchor, extra_sq_rad));
  }
  double sum = 0.0;
  for (const auto& [keypoint_idx, gain] : best) {
    sum += gain;
  }
  return sum;
}

TEST(ConsensusSet, GainAgreesWithItsDefinition) {
  for (const int num_keypoints : {1, 7, 64, 300}) {  // Around the block sizes.
    for (const double extra_sq_rad : {0.0, 1e-3}) {
      const Scene scene = MakeScene(num_keypoints, num_keypoints);
      ConsensusSet set(scene.observations);
      EXPECT_EQ(set.num_keypoints(), num_keypoints);
      EXPECT_NEAR(set.Gain(scene.cam_from_anchor.ToMatrix(), extra_sq_rad, -1.0),
                  ReferenceSum(scene, extra_sq_rad), 1e-3 * num_keypoints);
    }
  }
}

TEST(ConsensusSet, PlainAndVectorizedKernelsAgree) {
  ConsensusOptions plain_options;
  plain_options.kernel = ConsensusKernel::kPlain;
  for (const int num_keypoints : {1, 7, 64, 300}) {
    const Scene scene = MakeScene(num_keypoints, 100 + num_keypoints);
    ConsensusSet vectorized(scene.observations), plain(scene.observations, plain_options);
    for (int i = 0; i < 20; ++i) {
      const Rigid3d nearby =
          Rigid3d(ExpSo3(Vector3d(1e-3 * i, 0, -5e-4 * i)), Vector3d(0.01 * i, 0, 0)) *
          scene.cam_from_anchor;
      EXPECT_NEAR(vectorized.Gain(nearby.ToMatrix(), 0.0, -1.0),
                  plain.Gain(nearby.ToMatrix(), 0.0, -1.0), 1e-4 * num_keypoints);
      EXPECT_EQ(vectorized.BestObservations(nearby.ToMatrix(), 0.0),
                plain.BestObservations(nearby.ToMatrix(), 0.0));
    }
  }
}

TEST(ConsensusSet, RaysOfARigStartAtTheirOwnCamera) {
  // Moving a camera of a rig moves its landmarks with it: the gains are those of the single camera.
  const Scene scene = MakeScene(300, 21);
  std::vector<RayObservation> moved = scene.observations;
  for (RayObservation& observation : moved) {
    if (observation.keypoint_idx % 2 == 1) {
      observation.origin_in_cam = Vector3d(1.5, -0.5, 0.7);
      observation.x_in_anchor +=
          scene.cam_from_anchor.rotation.conjugate() * observation.origin_in_cam;
    }
  }
  for (const ConsensusKernel kernel : {ConsensusKernel::kVectorized, ConsensusKernel::kPlain}) {
    ConsensusOptions options;
    options.kernel = kernel;
    ConsensusSet single(scene.observations, options), rig(moved, options);
    const auto pose = scene.cam_from_anchor.ToMatrix();
    EXPECT_GT(single.Gain(pose, 0.0, -1.0), 50.0);
    EXPECT_NEAR(rig.Gain(pose, 0.0, -1.0), single.Gain(pose, 0.0, -1.0), 0.05);
  }
}

TEST(ConsensusSet, WithoutEarlyRejectionEveryGainIsWhole) {
  const Scene scene = MakeScene(500, 9);
  ConsensusOptions options;
  options.early_rejection = false;
  ConsensusSet set(scene.observations, options);
  const auto pose = scene.cam_from_anchor.ToMatrix();
  EXPECT_EQ(set.Gain(pose, 0.0, scene.observations.size() + 1.0), set.Gain(pose, 0.0, -1.0));
  EXPECT_GT(set.Gain(pose, 0.0, -1.0), 100.0);
}

TEST(ConsensusSet, FarOriginCostsNoPrecision) {
  const Scene scene = MakeScene(100, 5, {40'000.0, -70'000.0, 300.0});
  ConsensusSet set(scene.observations);
  EXPECT_NEAR(set.Gain(scene.cam_from_anchor.ToMatrix(), 0.0, -1.0), ReferenceSum(scene, 0.0), 0.1);
}

TEST(ConsensusSet, LandmarksBehindTheCameraGainNothing) {
  const RayObservation observation = {Vector3d::UnitZ(), {0, 0, -10}, 0.01, 0.0, 0};
  ConsensusSet set({observation});
  EXPECT_EQ(set.Gain(Rigid3d().ToMatrix(), 1.0, -1.0), 0.0);
}

TEST(ConsensusSet, LandmarkAtTheCameraCenterGainsNothing) {
  ConsensusSet set({{Vector3d::UnitZ(), {0, 0, 0}, 0.01, 0.1, 0}});
  EXPECT_EQ(set.Gain(Rigid3d().ToMatrix(), 0.0, -1.0), 0.0);
}

TEST(ConsensusSet, PicksBestObservationOfEachKeypoint) {
  const double t = 0.01;
  ConsensusSet set({{Vector3d::UnitZ(), {0.05, 0, 10}, t, 0.0, 3},
                    {Vector3d::UnitZ(), {0.01, 0, 10}, t, 0.0, 3},
                    {Vector3d::UnitZ(), {3.0, 0, 10}, t, 0.0, 8},
                    {Vector3d::UnitX(), {10, 0, 0.02}, t, 0.0, 9}});
  EXPECT_EQ(set.BestObservations(Rigid3d().ToMatrix(), 0.0), (std::vector<int>{1, -1, 3}));
}

TEST(ConsensusSet, GivesUpOnWhatCannotBeatTheBest) {
  const Scene scene = MakeScene(500, 9);
  ConsensusSet set(scene.observations);
  const double gain = set.Gain(scene.cam_from_anchor.ToMatrix(), 0.0, -1.0);
  EXPECT_EQ(set.Gain(scene.cam_from_anchor.ToMatrix(), 0.0, scene.observations.size() + 1.0), 0.0);
  // A model as good as the best so far is not taken for a bad one.
  EXPECT_EQ(set.Gain(scene.cam_from_anchor.ToMatrix(), 0.0, 0.95 * gain), gain);
  // A model without inliers is dropped.
  const Rigid3d elsewhere(Eigen::Quaterniond(0, 1, 0, 0), Vector3d(500, 0, 0));
  EXPECT_EQ(set.Gain(elsewhere.ToMatrix(), 0.0, gain), 0.0);
}

TEST(ConsensusSet, EmptySetGainsNothing) {
  ConsensusSet set({});
  EXPECT_EQ(set.num_keypoints(), 0);
  EXPECT_EQ(set.Gain(Rigid3d().ToMatrix(), 0.0, -1.0), 0.0);
  EXPECT_TRUE(set.BestObservations(Rigid3d().ToMatrix(), 0.0).empty());
}

}  // namespace
}  // namespace cairn
