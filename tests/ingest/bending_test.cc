#include "ingest/anchor/bending.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace cairn {
namespace {

// A walk of 300 m that the map sees displaced by `shift` and turned by `turn`, functions of the way
// along, with errors of 3 cm and 0.1 degrees.
template <typename Shift, typename Turn>
std::vector<PosePair> WalkWith(const Shift& shift, const Turn& turn, double step_m = 6.0) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  const auto noise = [&](double sigma) {
    return Eigen::Vector3d(sigma * normal(random), sigma * normal(random), sigma * normal(random));
  };
  std::vector<PosePair> pairs;
  for (double along_m = 0.0; along_m < 300.0; along_m += step_m) {
    const Rigid3d in_session(ExpSo3(Eigen::Vector3d(0.1, 0.2, 0.3)),
                             Eigen::Vector3d(along_m, 0, 1.6));
    const Rigid3d in_map(ExpSo3(turn(along_m) + noise(0.0017)) * in_session.rotation,
                         in_session.translation + shift(along_m) + noise(0.03));
    pairs.push_back({in_session.Inverse(), in_map.Inverse(), 0.056, 0.0032});
  }
  return pairs;
}

Eigen::Vector3d Nothing(double) { return Eigen::Vector3d::Zero(); }
Eigen::Vector3d Waves(double along_m) {
  return {0.3 * std::sin(along_m / 40.0), 0.3 * std::cos(along_m / 30.0), 0.0};
}
Eigen::Vector3d Turns(double along_m) { return {0.0, 0.0, 0.008 * std::sin(along_m / 40.0)}; }

Rigid3d CameraAt(double along_m) {
  return Rigid3d(ExpSo3(Eigen::Vector3d(0.1, 0.2, 0.3)), Eigen::Vector3d(along_m, 0, 1.6))
      .Inverse();
}

TEST(Bending, LeavesARigidSessionAlone) {
  const Bending bending = Bending::Fit(WalkWith(Nothing, Nothing));
  EXPECT_TRUE(bending.is_none());
  const Rigid3d bent = bending.Bend(CameraAt(33.0));
  EXPECT_EQ(bent.translation, CameraAt(33.0).translation);
}

TEST(Bending, FollowsADriftBetweenTheAnswers) {
  const Bending bending = Bending::Fit(WalkWith(Waves, Turns));
  for (double along_m = 3.0; along_m < 294.0; along_m += 6.0) {
    const Rigid3d bent = bending.Bend(CameraAt(along_m)).Inverse();
    const Eigen::Vector3d truth = Eigen::Vector3d(along_m, 0, 1.6) + Waves(along_m);
    EXPECT_LT((bent.translation - truth).norm(), 0.06) << along_m;
    EXPECT_LT(RotationAngleRad(bent.rotation,
                               ExpSo3(Turns(along_m)) * CameraAt(along_m).Inverse().rotation),
              0.003)
        << along_m;
  }
}

TEST(Bending, ReturnsToTheMotionOfTheWholeFarFromTheAnswers) {
  const Bending bending = Bending::Fit(WalkWith(Waves, Nothing));
  ASSERT_FALSE(bending.is_none());
  EXPECT_LT((bending.Bend(CameraAt(3000.0)).Inverse().translation -
             CameraAt(3000.0).Inverse().translation)
                .norm(),
            1e-6);
}

TEST(Bending, IsNotLedAstrayByAWrongAnswer) {
  std::vector<PosePair> pairs = WalkWith(Waves, Nothing);
  Rigid3d wrong = pairs[20].cam_from_ecef_in_map.Inverse();
  wrong.translation += Eigen::Vector3d(0, 0.5, 0);
  pairs[20].cam_from_ecef_in_map = wrong.Inverse();
  const Rigid3d bent = Bending::Fit(pairs).Bend(CameraAt(120.0)).Inverse();
  EXPECT_LT((bent.translation - Eigen::Vector3d(120.0, 0, 1.6) - Waves(120.0)).norm(), 0.08);
}

TEST(Bending, TellsWhatEachAnswerDiffersByFromTheOthers) {
  const Bending bending = Bending::Fit(WalkWith(Waves, Nothing));
  double sum_sq_m2 = 0.0;
  for (const Eigen::Vector3d& surprise : bending.shift().surprises()) {
    sum_sq_m2 += surprise.squaredNorm() / 3.0;
  }
  const double rms_m =
      std::sqrt(sum_sq_m2 / static_cast<double>(bending.shift().surprises().size()));
  EXPECT_GT(rms_m, 0.025);
  EXPECT_LT(rms_m, 0.05);
}

}  // namespace
}  // namespace cairn
