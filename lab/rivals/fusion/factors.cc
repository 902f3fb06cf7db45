#include "lab/rivals/fusion/factors.h"

#include "core/inertial/so3_jacobians.h"

namespace cairn::fusion {
namespace {

template <int kRows, int kCols>
using RowMajorMap = Eigen::Map<Eigen::Matrix<double, kRows, kCols, Eigen::RowMajor>>;
using Matrix23d = Eigen::Matrix<double, 2, 3>;

// Projects x. Returns false if x is not in front of the camera. `by_local` is P' A / sigma.
bool Project(const WindowCamera& camera, const Eigen::Vector3d& from_imu_in_local,
             const Eigen::Vector2d& normalized, double inverse_sigma, double* residuals,
             Matrix23d* by_local) {
  const Eigen::Vector3d y = camera.cam_from_local_rotation * from_imu_in_local + camera.imu_in_cam;
  if (!(y.z() > kMinFactorDepthM)) {
    return false;
  }
  const double inverse_depth = 1.0 / y.z();
  const Eigen::Vector2d image = y.head<2>() * inverse_depth;
  residuals[0] = inverse_sigma * (image.x() - normalized.x());
  residuals[1] = inverse_sigma * (image.y() - normalized.y());
  if (by_local != nullptr) {
    const double scale = inverse_sigma * inverse_depth;
    const Eigen::Matrix3d& a = camera.cam_from_local_rotation;
    by_local->row(0) = scale * (a.row(0) - image.x() * a.row(2));
    by_local->row(1) = scale * (a.row(1) - image.y() * a.row(2));
  }
  return true;
}

// Writes the Jacobian by [theta, p] of the camera.
void SetByPose(const WindowCamera& camera, const Eigen::Vector3d& from_imu_in_local,
               const Matrix23d& by_local, double* jacobian) {
  RowMajorMap<2, kPoseBlock> by_pose(jacobian);
  Matrix23d by_rotation;
  by_rotation.row(0) = by_local.row(0).cross(from_imu_in_local);
  by_rotation.row(1) = by_local.row(1).cross(from_imu_in_local);
  by_pose.leftCols<3>().noalias() = by_rotation * camera.theta_jacobian;
  by_pose.rightCols<3>() = -by_local;
}

// Evaluates a factor of a camera's pose (jacobians[0]) and another block (jacobians[1]). Calls
// set_by_other(by_local) if the Jacobian by the other block is wanted.
template <typename SetByOther>
bool Reproject(const WindowCamera& camera, const Eigen::Vector3d& from_imu_in_local,
               const Eigen::Vector2d& normalized, double inverse_sigma, double* residuals,
               double** jacobians, const SetByOther& set_by_other) {
  Matrix23d by_local;
  if (!Project(camera, from_imu_in_local, normalized, inverse_sigma, residuals,
               jacobians != nullptr ? &by_local : nullptr)) {
    return false;
  }
  if (jacobians != nullptr && jacobians[0] != nullptr) {
    SetByPose(camera, from_imu_in_local, by_local, jacobians[0]);
  }
  if (jacobians != nullptr && jacobians[1] != nullptr) {
    set_by_other(by_local);
  }
  return true;
}

}  // namespace

bool LocalFactor::Evaluate(double const* const* parameters, double* residuals,
                           double** jacobians) const {
  const Eigen::Vector3d from_imu =
      Eigen::Map<const Eigen::Vector3d>(parameters[1]) - camera_->position_in_local;
  const auto set_by_landmark = [&](const Matrix23d& by_local) {
    RowMajorMap<2, kLandmarkBlock> by_landmark(jacobians[1]);
    by_landmark = by_local;
  };
  return Reproject(*camera_, from_imu, normalized_, inverse_sigma_, residuals, jacobians,
                   set_by_landmark);
}

bool GlobalFactor::Evaluate(double const* const* /*parameters*/, double* residuals,
                            double** jacobians) const {
  const Eigen::Vector3d from_pivot = x_in_global_ - alignment_->pivot_in_global;
  const Eigen::Vector3d from_imu = alignment_->local_from_global_rotation * from_pivot +
                                   alignment_->pivot_in_local - camera_->position_in_local;
  const auto set_by_alignment = [&](const Matrix23d& by_local) {
    const Matrix23d by_global = by_local * alignment_->local_from_global_rotation;
    RowMajorMap<2, kGlobalBlock> by_alignment(jacobians[1]);
    by_alignment.col(0) = by_global.col(0) * from_pivot.y() - by_global.col(1) * from_pivot.x();
    by_alignment.rightCols<3>() = -by_global;
  };
  return Reproject(*camera_, from_imu, normalized_, inverse_sigma_, residuals, jacobians,
                   set_by_alignment);
}

namespace {

// The terms of an inertial residual that its Jacobians need.
struct ImuTerms {
  Eigen::Matrix3d from_rotation;    // R_i'.
  Eigen::Vector3d delta_rotation;   // First-order change of dR by the biases.
  Eigen::Vector3d rotation_error;   // r_theta.
  Eigen::Vector3d position_change;  // In local.
  Eigen::Vector3d velocity_change;  // In local.
  Eigen::Matrix<double, 9, 6> by_biases;
  double dt_s;
};

ImuTerms EvaluateImu(const WindowCamera& from, const WindowCamera& to,
                     const Eigen::Vector3d& gravity, double const* const* parameters,
                     Eigen::Matrix<double, 15, 1>* residual) {
  const Eigen::Map<const Eigen::Matrix<double, kMotionBlock, 1>> from_motion(parameters[1]);
  const Eigen::Map<const Eigen::Matrix<double, kMotionBlock, 1>> to_motion(parameters[3]);
  const ImuState& delta = to.since_previous.delta();
  Eigen::Matrix<double, 6, 1> bias_change = from_motion.tail<6>();
  bias_change.head<3>() -= delta.gyro_bias;
  bias_change.tail<3>() -= delta.accel_bias;

  ImuTerms terms;
  terms.by_biases = to.since_previous.ByBiases();
  terms.dt_s = to.since_previous.duration_s();
  const Eigen::Matrix<double, 9, 1> change = terms.by_biases * bias_change;
  terms.delta_rotation = change.head<3>();
  terms.from_rotation = from.rotation.conjugate().toRotationMatrix();
  terms.rotation_error =
      LogSo3(from.rotation.conjugate() * to.rotation *
             (ExpSo3(terms.delta_rotation) * delta.local_from_imu.rotation).conjugate());
  terms.velocity_change = to_motion.head<3>() - from_motion.head<3>() - gravity * terms.dt_s;
  terms.position_change = to.position_in_local - from.position_in_local -
                          from_motion.head<3>() * terms.dt_s -
                          0.5 * terms.dt_s * terms.dt_s * gravity;
  *residual << terms.rotation_error,
      terms.from_rotation * terms.position_change - delta.local_from_imu.translation -
          change.segment<3>(3),
      terms.from_rotation * terms.velocity_change - delta.velocity_in_local - change.tail<3>(),
      to_motion.tail<6>() - from_motion.tail<6>();
  return terms;
}

Eigen::Matrix<double, 15, kPoseBlock> ByFromPose(const ImuTerms& terms, const WindowCamera& from) {
  Eigen::Matrix<double, 15, kPoseBlock> jacobian = Eigen::Matrix<double, 15, kPoseBlock>::Zero();
  const Eigen::Matrix3d turn = terms.from_rotation * from.theta_jacobian;
  jacobian.block<3, 3>(0, 0) = -InverseLeftJacobian(terms.rotation_error) * turn;
  jacobian.block<3, 3>(3, 0) =
      terms.from_rotation * Skew(terms.position_change) * from.theta_jacobian;
  jacobian.block<3, 3>(3, 3) = -terms.from_rotation;
  jacobian.block<3, 3>(6, 0) =
      terms.from_rotation * Skew(terms.velocity_change) * from.theta_jacobian;
  return jacobian;
}

Eigen::Matrix<double, 15, kPoseBlock> ByToPose(const ImuTerms& terms, const WindowCamera& to) {
  Eigen::Matrix<double, 15, kPoseBlock> jacobian = Eigen::Matrix<double, 15, kPoseBlock>::Zero();
  jacobian.block<3, 3>(0, 0) =
      InverseLeftJacobian(terms.rotation_error) * terms.from_rotation * to.theta_jacobian;
  jacobian.block<3, 3>(3, 3) = terms.from_rotation;
  return jacobian;
}

Eigen::Matrix<double, 15, kMotionBlock> ByFromMotion(const ImuTerms& terms) {
  Eigen::Matrix<double, 15, kMotionBlock> jacobian =
      Eigen::Matrix<double, 15, kMotionBlock>::Zero();
  jacobian.block<3, 3>(3, 0) = -terms.dt_s * terms.from_rotation;
  jacobian.block<3, 3>(6, 0) = -terms.from_rotation;
  // The right Jacobian is the transpose of the left one.
  jacobian.block<3, 6>(0, 3) = -InverseLeftJacobian(terms.rotation_error).transpose() *
                               LeftJacobian(terms.delta_rotation) * terms.by_biases.topRows<3>();
  jacobian.block<6, 6>(3, 3) = -terms.by_biases.bottomRows<6>();
  jacobian.block<6, 6>(9, 3) = -Eigen::Matrix<double, 6, 6>::Identity();
  return jacobian;
}

Eigen::Matrix<double, 15, kMotionBlock> ByToMotion(const ImuTerms& terms) {
  Eigen::Matrix<double, 15, kMotionBlock> jacobian =
      Eigen::Matrix<double, 15, kMotionBlock>::Zero();
  jacobian.block<3, 3>(6, 0) = terms.from_rotation;
  jacobian.block<6, 6>(9, 3) = Eigen::Matrix<double, 6, 6>::Identity();
  return jacobian;
}

}  // namespace

bool ImuFactor::Evaluate(double const* const* parameters, double* residuals,
                         double** jacobians) const {
  Eigen::Matrix<double, 15, 1> residual;
  const ImuTerms terms = EvaluateImu(*from_, *to_, gravity_in_local_, parameters, &residual);
  const Matrix15d& whiten = to_->imu_sqrt_information;
  const auto lower = whiten.triangularView<Eigen::Lower>();
  Eigen::Map<Eigen::Matrix<double, 15, 1>>(residuals).noalias() = lower * residual;
  if (jacobians == nullptr) {
    return true;
  }
  if (jacobians[0] != nullptr) {
    RowMajorMap<15, kPoseBlock>(jacobians[0]).noalias() = lower * ByFromPose(terms, *from_);
  }
  if (jacobians[1] != nullptr) {
    RowMajorMap<15, kMotionBlock>(jacobians[1]).noalias() = lower * ByFromMotion(terms);
  }
  if (jacobians[2] != nullptr) {
    RowMajorMap<15, kPoseBlock>(jacobians[2]).noalias() = lower * ByToPose(terms, *to_);
  }
  if (jacobians[3] != nullptr) {
    RowMajorMap<15, kMotionBlock>(jacobians[3]).noalias() = lower * ByToMotion(terms);
  }
  return true;
}

bool GaugeFactor::Evaluate(double const* const* parameters, double* residuals,
                           double** jacobians) const {
  const double* pose = parameters[0];
  residuals[0] = inverse_sigma_rad_ * pose[2];
  for (int i = 0; i < 3; ++i) {
    residuals[1 + i] = inverse_sigma_m_ * (pose[3 + i] - position_in_local_[i]);
  }
  if (jacobians != nullptr && jacobians[0] != nullptr) {
    RowMajorMap<4, kPoseBlock> jacobian(jacobians[0]);
    jacobian.setZero();
    jacobian(0, 2) = inverse_sigma_rad_;
    jacobian.bottomRightCorner<3, 3>().diagonal().setConstant(inverse_sigma_m_);
  }
  return true;
}

bool BiasFactor::Evaluate(double const* const* parameters, double* residuals,
                          double** jacobians) const {
  const Eigen::Map<const Eigen::Matrix<double, 6, 1>> biases(parameters[0] + 3);
  Eigen::Map<Eigen::Matrix<double, 6, 1>>(residuals).noalias() =
      inverse_sigmas_.cwiseProduct(biases - biases_);
  if (jacobians != nullptr && jacobians[0] != nullptr) {
    RowMajorMap<6, kMotionBlock> jacobian(jacobians[0]);
    jacobian.setZero();
    jacobian.rightCols<6>().diagonal() = inverse_sigmas_;
  }
  return true;
}

}  // namespace cairn::fusion
