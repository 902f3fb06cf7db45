#include "fusion/tracks/triangulate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace cairn::fusion {
namespace {

// Observations of one point by a camera that moves along its view, 6 to 60 cm from observation to
// observation.
class TriangulateTest : public ::testing::Test {
 protected:
  TriangulateTest() : camera_(CameraModel::kPinhole, 640, 480, {460.0, 460.0, 320.0, 240.0}) {}

  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  Eigen::Vector3d Gaussian(double sigma) {
    std::normal_distribution<double> normal(0.0, sigma);
    const double x = normal(random_);
    const double y = normal(random_);
    return {x, y, normal(random_)};
  }

  // A point `depth_m` ahead of the last of `num_views` views, at a slant of up to 35 degrees.
  Eigen::Vector3d MakeViews(int num_views, double depth_m) {
    const double step_m = Uniform(0.06, 0.6);
    views_.clear();
    for (int i = 0; i < num_views; ++i) {
      const Eigen::Quaterniond rotation = ExpSo3(Gaussian(0.02));
      const Eigen::Vector3d position =
          Gaussian(0.01) - (num_views - 1 - i) * step_m * Eigen::Vector3d::UnitZ();
      views_.emplace_back(Rig(), Clone{i, i, Rigid3d(rotation, position), position});
    }
    return depth_m * Eigen::Vector3d(Uniform(-0.6, 0.6), Uniform(-0.45, 0.45), 1.0);
  }

  // What the views see of `x`; false if it is out of some picture.
  bool Observe(const Eigen::Vector3d& x, double sigma_px) {
    observations_.clear();
    for (const CameraView& view : views_) {
      const auto predicted = PredictPixel(camera_, view, x);
      if (!predicted) {
        return false;
      }
      const Eigen::Vector2d pixel = predicted->pixel + Gaussian(sigma_px).head<2>();
      const auto ray = camera_.Unproject(pixel);
      if (!ray) {
        return false;
      }
      observations_.push_back({&view, pixel, *ray});
    }
    return true;
  }

  // Sum of squared residuals in pixels; infinite if some view does not see `x`.
  double Cost(const Eigen::Vector3d& x) const {
    double cost = 0.0;
    for (const PosedObservation& observation : observations_) {
      const auto predicted = PredictPixel(camera_, *observation.view, x);
      cost += predicted ? (observation.pixel - predicted->pixel).squaredNorm() : INFINITY;
    }
    return cost;
  }

  std::mt19937_64 random_{7};
  Camera camera_;
  std::vector<CameraView> views_;
  std::vector<PosedObservation> observations_;
};

TEST_F(TriangulateTest, FindsThePointOfExactObservations) {
  int num_found = 0;
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d x = MakeViews(2 + i % 9, std::exp(Uniform(0.0, 4.0)));
    if (!Observe(x, 0.0)) {
      continue;
    }
    const auto found = Triangulate(camera_, observations_, 0.01, {});
    if (found) {
      ++num_found;
      EXPECT_LT((*found - x).norm(), 1e-4 * x.norm());
    }
  }
  EXPECT_GT(num_found, 300);
}

// A point so far away that pixels alone do not tell its distance.
TEST_F(TriangulateTest, ADistanceKnownBeforehandMakesUpForAShortBaseline) {
  int num_refused = 0;
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d x = MakeViews(3, Uniform(20.0, 40.0));
    if (!Observe(x, 0.0)) {
      continue;
    }
    num_refused += Triangulate(camera_, observations_, 1.0, {}).has_value() ? 0 : 1;
    const Eigen::Vector3d across = x.unitOrthogonal();
    const auto found = Triangulate(camera_, observations_, 1.0, {},
                                   PlanePrior{x + 0.3 * across, x.normalized(), 0.05});
    ASSERT_TRUE(found.has_value());
    EXPECT_LT((*found - x).norm(), 0.01);
  }
  EXPECT_GT(num_refused, 50);
}

// With poses that are off, as those of a filter that has just started, the rays to a far point may
// part. The point is then not known, or at least where the observations say: it never explains them
// worse than the true one does.
TEST_F(TriangulateTest, NeverStopsShortOfTheMinimum) {
  int num_found = 0;
  for (int i = 0; i < 4000; ++i) {
    const Eigen::Vector3d x = MakeViews(3 + i % 8, std::exp(Uniform(0.7, 3.4)));
    if (!Observe(x, 1.0)) {
      continue;
    }
    const Eigen::Vector3d drift = Gaussian(0.03);
    for (size_t k = 0; k < views_.size(); ++k) {
      views_[k].center_in_local += static_cast<double>(k) * drift;
    }
    const auto found = Triangulate(camera_, observations_, 1.0, {});
    if (found) {
      ++num_found;
      EXPECT_LT(Cost(*found), 1.001 * Cost(x))
          << "found at " << found->transpose() << ", true at " << x.transpose();
    }
  }
  EXPECT_GT(num_found, 1000);
}

}  // namespace
}  // namespace cairn::fusion
