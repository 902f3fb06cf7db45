// The normal equations of many reprojections, computed eight at a time.
#ifndef CAIRN_ENGINE_POSE_NORMAL_EQUATIONS_H_
#define CAIRN_ENGINE_POSE_NORMAL_EQUATIONS_H_

#include <Eigen/Core>
#include <array>

#include "engine/pose/pose_residuals.h"

namespace cairn {

// Scale of the Cauchy loss, in standard deviations. 2.4 keeps 95 % of the efficiency of least
// squares on Gaussian noise.
inline constexpr double kCauchyScale = 2.4;

// Parameters of the weight of a residual.
struct ResidualWeights {
  double keypoint_sigma_px = 1.0;      // Standard deviation of a keypoint per axis.
  double cauchy_scale = kCauchyScale;  // In standard deviations.
};

// Returns 1 / (keypoint_sigma_px^2 + (landmark_px_m / distance)^2). `landmark_px_m` is the focal
// length times the standard deviation of the landmark, pixels times meters.
double ReprojectionInformation(const ResidualWeights& weights, double landmark_px_m,
                               double sq_distance_m);
// Returns 1 / (1 + sq_residual / cauchy_scale^2). The squared residual is in standard deviations.
double RobustWeight(const ResidualWeights& weights, double sq_residual);

// Sums w J'J, w J'r and the Cauchy losses of reprojection residuals r. w is the information times
// the robust weight. J is the Jacobian with respect to (rotation, translation) of the camera, see
// pose_residuals.h: [A Skew(d), -A]. A is the derivative of the pixel with respect to the landmark.
// d is the vector from the center of the pose's rotation to the landmark. Results may differ in the
// last bits between processors.
class NormalEquations {
 public:
  explicit NormalEquations(const ResidualWeights& weights) : weights_(weights) {}

  void Add(const Eigen::Matrix<double, 2, 3>& pixel_by_anchor, const Eigen::Vector3d& from_center,
           const Eigen::Vector2d& residual_px, double landmark_px_m);

  // Sums over all residuals added so far.
  struct Sums {
    Eigen::Matrix<double, 6, 6> normal;
    PoseTangent gradient;
    double cost = 0.0;  // Half the sum of the losses.
  };
  Sums Finish();

  static constexpr int kNumLanes = 8;
  using Lanes = std::array<double, kNumLanes>;
  // Residuals that wait until the batch is full.
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
  int num_batches_ = 0;  // Since sum_of_logs_ was last updated.
  double sum_of_logs_ = 0.0;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_NORMAL_EQUATIONS_H_
