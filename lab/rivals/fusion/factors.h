// The residuals of the bundle adjustment with analytic Jacobians.
//
// Symbols: R is the rotation and p the translation of a camera's local_from_imu; A is the rotation
// of cam_from_local; x is a landmark in local; y = A (x - p) + (imu in cam) is the landmark in cam.
// P is the projection onto the plane z = 1, with the Jacobian P' = 1/z [1 0 -y1/z; 0 1 -y2/z].
// J_l(theta) maps a change of theta to a change of the rotation (window_variables.h).
//
// The factors read their parameters through the cameras, so PrepareVariables must have run at the
// point of evaluation.
#ifndef CAIRN_LAB_RIVALS_FUSION_FACTORS_H_
#define CAIRN_LAB_RIVALS_FUSION_FACTORS_H_

#include <ceres/sized_cost_function.h>

#include <Eigen/Core>

#include "lab/rivals/fusion/window_variables.h"

namespace cairn::fusion {

// Smallest depth of a residual. A smaller depth makes the evaluation fail, which rejects the step.
inline constexpr double kMinFactorDepthM = 0.05;

// A local landmark seen by a camera: (P(y) - measured) / sigma.
//   by theta  P' A [x - p]x J_l    by p  -P' A    by x  P' A
class LocalFactor final : public ceres::SizedCostFunction<2, kPoseBlock, kLandmarkBlock> {
 public:
  // `normalized` and its standard deviation `sigma` are on the plane z = 1.
  void Set(const WindowCamera* camera, const Eigen::Vector2d& normalized, double sigma) {
    camera_ = camera;
    normalized_ = normalized;
    inverse_sigma_ = 1.0 / sigma;
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const WindowCamera* camera_ = nullptr;
  Eigen::Vector2d normalized_ = Eigen::Vector2d::Zero();
  double inverse_sigma_ = 1.0;
};

// A camera sees a map landmark that is fixed in global. x = R_GL' (x_G - c_G) + c_L with the pivot
// c. The derivatives are those of LocalFactor, and
//   by psi  P' A R_GL' ((x_G - c_G) x e_z)    by c_G  -P' A R_GL'
class GlobalFactor final : public ceres::SizedCostFunction<2, kPoseBlock, kGlobalBlock> {
 public:
  void Set(const WindowCamera* camera, const WindowAlignment* alignment,
           const Eigen::Vector2d& normalized, double sigma, const Eigen::Vector3d& x_in_global) {
    camera_ = camera;
    alignment_ = alignment;
    normalized_ = normalized;
    inverse_sigma_ = 1.0 / sigma;
    x_in_global_ = x_in_global;
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const WindowCamera* camera_ = nullptr;
  const WindowAlignment* alignment_ = nullptr;
  Eigen::Vector2d normalized_ = Eigen::Vector2d::Zero();
  double inverse_sigma_ = 1.0;
  Eigen::Vector3d x_in_global_ = Eigen::Vector3d::Zero();
};

// The preintegrated motion from camera i to its successor j over dt, whitened. The preintegrated
// dR, dp and dv are first moved to the biases of i by their first-order change. Before whitening:
//   r_theta = Log(R_i' R_j dR')
//   r_p     = R_i' (p_j - p_i - v_i dt - g dt^2 / 2) - dp
//   r_v     = R_i' (v_j - v_i - g dt) - dv
//   r_bg    = b_g,j - b_g,i    r_ba = b_a,j - b_a,i
class ImuFactor final
    : public ceres::SizedCostFunction<15, kPoseBlock, kMotionBlock, kPoseBlock, kMotionBlock> {
 public:
  void Set(const WindowCamera* from, const WindowCamera* to, double gravity_m_s2) {
    from_ = from;
    to_ = to;
    gravity_in_local_ = {0.0, 0.0, -gravity_m_s2};
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  const WindowCamera* from_ = nullptr;
  const WindowCamera* to_ = nullptr;
  Eigen::Vector3d gravity_in_local_ = Eigen::Vector3d::Zero();
};

// Holds the four unobservable degrees of freedom of the window (position and heading) at their
// values in the oldest camera: (e_z . theta) / sigma_rad, (p - p_0) / sigma_m.
class GaugeFactor final : public ceres::SizedCostFunction<4, kPoseBlock> {
 public:
  void Set(const Eigen::Vector3d& position_in_local, double sigma_rad, double sigma_m) {
    position_in_local_ = position_in_local;
    inverse_sigma_rad_ = 1.0 / sigma_rad;
    inverse_sigma_m_ = 1.0 / sigma_m;
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  Eigen::Vector3d position_in_local_ = Eigen::Vector3d::Zero();
  double inverse_sigma_rad_ = 1.0;
  double inverse_sigma_m_ = 1.0;
};

// Prior knowledge of a camera's biases from outside the window: (b_g - b_g0) / sigma, (b_a - b_a0)
// / sigma.
class BiasFactor final : public ceres::SizedCostFunction<6, kMotionBlock> {
 public:
  void Set(const Eigen::Vector3d& gyro_bias, const Eigen::Vector3d& accel_bias,
           double gyro_sigma_rad_s, double accel_sigma_m_s2) {
    biases_ << gyro_bias, accel_bias;
    inverse_sigmas_ << Eigen::Vector3d::Constant(1.0 / gyro_sigma_rad_s),
        Eigen::Vector3d::Constant(1.0 / accel_sigma_m_s2);
  }
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  Eigen::Matrix<double, 6, 1> biases_ = Eigen::Matrix<double, 6, 1>::Zero();
  Eigen::Matrix<double, 6, 1> inverse_sigmas_ = Eigen::Matrix<double, 6, 1>::Ones();
};

}  // namespace cairn::fusion

#endif  // CAIRN_LAB_RIVALS_FUSION_FACTORS_H_
