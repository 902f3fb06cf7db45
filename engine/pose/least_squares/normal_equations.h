// The normal equations of many reprojections, eight of them at a time.
#ifndef CAIRN_ENGINE_POSE_LEAST_SQUARES_NORMAL_EQUATIONS_H_
#define CAIRN_ENGINE_POSE_LEAST_SQUARES_NORMAL_EQUATIONS_H_

#include <Eigen/Core>
#include <array>

#include "engine/pose/least_squares/pose_residuals.h"

namespace cairn {

// What weighs a residual.
struct ResidualWeights {
  double keypoint_sigma_px = 1.0;  // Standard deviation of a keypoint per axis.
  double cauchy_scale = 2.4;       // In standard deviations.
};

// 1 / (keypoint_sigma_px^2 + (landmark_px_m / distance)^2): `landmark_px_m` is the focal length
// times the standard deviation of the landmark, pixels times metres.
double ReprojectionInformation(const ResidualWeights& weights, double landmark_px_m,
                               double sq_distance_m);
// 1 / (1 + sq_residual / cauchy_scale^2), of a squared residual in standard deviations.
double RobustWeight(const ResidualWeights& weights, double sq_residual);

// Sums w J'J, w J'r and Cauchy losses of reprojections r whose Jacobian by (rotation, translation)
// of the camera, as in pose_residuals.h, is [A Skew(d), -A]: A is the derivative of the pixel by
// the landmark, d the way to it from the centre that the pose turns about. w is the information
// times the robust weight. Results may differ in the last bits between processors.
class NormalEquations {
 public:
  explicit NormalEquations(const ResidualWeights& weights) : weights_(weights) {}

  void Add(const Eigen::Matrix<double, 2, 3>& pixel_by_anchor, const Eigen::Vector3d& from_center,
           const Eigen::Vector2d& residual_px, double landmark_px_m);

  // The sums over all that was added so far.
  struct Sums {
    Eigen::Matrix<double, 6, 6> normal;
    PoseTangent gradient;
    double cost = 0.0;  // Half the sum of the losses.
  };
  Sums Finish();

  static constexpr int kNumLanes = 8;
  using Lanes = std::array<double, kNumLanes>;
  // What was added, until there are enough of them.
  struct Batch {
    std::array<Lanes, 6> pixel_by_anchor{};  // Row-major.
    std::array<Lanes, 3> from_center{};
    std::array<Lanes, 2> residual_px{};
    Lanes landmark_px_m{};
  };
  struct LaneSums {
    std::array<Lanes, 21> normal{};  // The upper triangle, row by row.
    std::array<Lanes, 6> gradient{};
    Lanes loss_product;  // Of 1 + sq_residual / cauchy_scale^2.
  };

 private:
  void Flush();

  ResidualWeights weights_;
  Batch batch_;
  LaneSums sums_ = {.loss_product = {1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0}};
  int num_in_batch_ = 0;
  int num_batches_ = 0;  // Since the products were made logarithms.
  double sum_of_logs_ = 0.0;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_LEAST_SQUARES_NORMAL_EQUATIONS_H_
