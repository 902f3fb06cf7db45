#include <Eigen/Cholesky>
#include <algorithm>
#include <vector>

#include "core/error.h"
#include "core/inertial/imu_buffer.h"
#include "core/rotation_between.h"
#include "eval/recordings/simulate_recording.h"
#include "eval/recordings/trajectory_interpolation.h"

namespace cairn::fusion {
namespace {

constexpr int64_t kTurnSpanNs = 500'000'000;
constexpr int64_t kVelocitySpanNs = 1'000'000'000;
constexpr int64_t kMarginNs = 100'000'000;  // Velocities need poses on both sides.

struct Extent {
  int64_t begin_ns, end_ns;
};

Extent CommonExtent(const Trajectory& trajectory) {
  const std::vector<ImuSample>& imu = trajectory.imu;
  const std::vector<TruePose>& poses = trajectory.poses;
  const bool is_empty = imu.size() < 2 || poses.size() < 2;
  const Extent extent =
      is_empty ? Extent{0, 0}
               : Extent{std::max(imu.front().timestamp_ns, poses.front().timestamp_ns) + kMarginNs,
                        std::min(imu.back().timestamp_ns, poses.back().timestamp_ns) - kMarginNs};
  if (extent.end_ns - extent.begin_ns < 3'000'000'000 - 2 * kMarginNs) {
    throw Error(ErrorCode::kBadInput,
                "trajectory " + trajectory.name + ": spans less than three seconds");
  }
  return extent;
}

Eigen::Vector3d GyroBias(const Trajectory& trajectory, const ImuBuffer& buffer,
                         const Extent& extent) {
  Eigen::Vector3d bias = Eigen::Vector3d::Zero();
  for (int iteration = 0; iteration < 3; ++iteration) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int count = 0;
    for (int64_t t = extent.begin_ns; t + kTurnSpanNs <= extent.end_ns; t += kTurnSpanNs) {
      Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
      buffer.ForEachStep(t, t + kTurnSpanNs, [&](const ImuStep& step) {
        turn = turn * ExpSo3((step.gyro_rad_s - bias) * step.dt_s);
      });
      const Eigen::Quaterniond truth = PoseAt(trajectory.poses, t).rotation.conjugate() *
                                       PoseAt(trajectory.poses, t + kTurnSpanNs).rotation;
      sum += LogSo3(truth.conjugate() * turn);
      ++count;
    }
    bias += sum / (count * 1e-9 * static_cast<double>(kTurnSpanNs));
  }
  return bias;
}

struct ForceFit {
  Eigen::Vector3d accel_bias;
  Eigen::Vector3d gravity_in_global;
};

// Least squares for: change of velocity = sum of R (a - b) dt + g dt.
ForceFit FitForces(const Trajectory& trajectory, const ImuBuffer& buffer, const Extent& extent,
                   const Eigen::Vector3d& gyro_bias) {
  Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
  for (int64_t t = extent.begin_ns; t + kVelocitySpanNs <= extent.end_ns; t += kVelocitySpanNs) {
    Eigen::Quaterniond rotation = PoseAt(trajectory.poses, t).rotation;
    Eigen::Matrix<double, 3, 6> jacobian = Eigen::Matrix<double, 3, 6>::Zero();
    Eigen::Vector3d change = VelocityAt(trajectory.poses, t + kVelocitySpanNs);
    change -= VelocityAt(trajectory.poses, t);
    buffer.ForEachStep(t, t + kVelocitySpanNs, [&](const ImuStep& step) {
      const Eigen::Vector3d turn = (step.gyro_rad_s - gyro_bias) * step.dt_s;
      const Eigen::Matrix3d middle = (rotation * ExpSo3(0.5 * turn)).toRotationMatrix();
      jacobian.leftCols<3>() -= middle * step.dt_s;
      jacobian.rightCols<3>() += step.dt_s * Eigen::Matrix3d::Identity();
      change -= middle * step.accel_m_s2 * step.dt_s;
      rotation = rotation * ExpSo3(turn);
    });
    normal += jacobian.transpose() * jacobian;
    right += jacobian.transpose() * change;
  }
  // For an upright device, the magnitude of gravity and the bias of the vertical axis are
  // indistinguishable. The magnitude is therefore held.
  constexpr double kSurely = 1e9;
  normal(5, 5) += kSurely;
  right[5] -= kSurely * trajectory.gravity_m_s2;
  const Eigen::Matrix<double, 6, 1> solution = normal.ldlt().solve(right);
  return {solution.head<3>(), solution.tail<3>()};
}

}  // namespace

void FitToSamples(Trajectory* trajectory) {
  const Extent extent = CommonExtent(*trajectory);
  ImuBuffer buffer(static_cast<int>(trajectory->imu.size()));
  for (const ImuSample& sample : trajectory->imu) {
    buffer.Push(sample);
  }
  trajectory->gyro_bias = GyroBias(*trajectory, buffer, extent);
  const ForceFit fit = FitForces(*trajectory, buffer, extent, trajectory->gyro_bias);
  trajectory->accel_bias = fit.accel_bias;
  const Rigid3d level(RotationBetween(fit.gravity_in_global, -Eigen::Vector3d::UnitZ()),
                      Eigen::Vector3d::Zero());
  for (TruePose& pose : trajectory->poses) {
    pose.global_from_imu = level * pose.global_from_imu;
  }
}

}  // namespace cairn::fusion
