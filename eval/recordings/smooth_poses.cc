#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "core/error.h"
#include "core/inertial/imu_buffer.h"
#include "core/inertial/imu_propagation.h"
#include "eval/recordings/simulate_recording.h"
#include "eval/recordings/trajectory_interpolation.h"

namespace cairn::fusion {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

struct Gaussian {
  ImuState mean;
  Matrix15d covariance;
};

// A time at which a pose is wanted, with the captured pose if there is one.
struct Knot {
  int64_t timestamp_ns = 0;
  std::optional<Rigid3d> captured;
};

// One knot in the forward pass.
struct FilteredPose {
  Gaussian predicted, updated;
  Matrix15d from_previous = Matrix15d::Identity();
};

// Returns the poses and, where linear interpolation between two poses would be too coarse, the
// samples between them.
std::vector<Knot> Knots(const Trajectory& trajectory) {
  constexpr int64_t kMaxStepNs = 20'000'000;
  std::vector<Knot> knots;
  auto sample = trajectory.imu.begin();
  for (const TruePose& pose : trajectory.poses) {
    const int64_t last_ns = knots.empty() ? pose.timestamp_ns : knots.back().timestamp_ns;
    for (; sample != trajectory.imu.end() && sample->timestamp_ns < pose.timestamp_ns; ++sample) {
      if (pose.timestamp_ns - last_ns > kMaxStepNs && sample->timestamp_ns > last_ns) {
        knots.push_back({sample->timestamp_ns, std::nullopt});
      }
    }
    knots.push_back({pose.timestamp_ns, pose.global_from_imu});
  }
  return knots;
}

// The state before the first pose is applied.
Gaussian Start(const Trajectory& trajectory) {
  Gaussian start;
  start.mean.local_from_imu = trajectory.poses.front().global_from_imu;
  start.mean.velocity_in_local =
      VelocityAt(trajectory.poses, trajectory.poses.front().timestamp_ns);
  start.mean.gyro_bias = trajectory.gyro_bias;
  start.mean.accel_bias = trajectory.accel_bias;
  Vector15d sigma;
  sigma << Eigen::Vector3d::Constant(0.05), Eigen::Vector3d::Constant(0.05),
      Eigen::Vector3d::Constant(0.2), Eigen::Vector3d::Constant(0.005),
      Eigen::Vector3d::Constant(0.1);
  start.covariance = sigma.cwiseAbs2().asDiagonal();
  return start;
}

void Predict(const ImuBuffer& buffer, int64_t begin_ns, int64_t end_ns, const ImuNoise& noise,
             double gravity_m_s2, FilteredPose* pose) {
  ImuState& mean = pose->predicted.mean;
  FirstEstimate first = {mean.local_from_imu.translation, mean.velocity_in_local};
  ImuTransition transition;
  buffer.ForEachStep(begin_ns, end_ns, [&](const ImuStep& step) {
    Propagate(step, noise, gravity_m_s2, &mean, &first, &transition);
  });
  Matrix15d& covariance = pose->predicted.covariance;
  const Matrix15d moved = transition.phi * covariance;
  covariance = moved * transition.phi.transpose() + transition.noise;
  pose->from_previous = transition.phi;
}

Gaussian Updated(Gaussian state, const Rigid3d& measured, const PoseNoise& noise) {
  Eigen::Matrix<double, 6, 1> residual;
  const Rigid3d& predicted = state.mean.local_from_imu;
  residual << LogSo3(measured.rotation * predicted.rotation.conjugate()),
      measured.translation - predicted.translation;
  Matrix6d innovation = state.covariance.topLeftCorner<6, 6>();
  innovation.diagonal().head<3>().array() += noise.rotation_sigma_rad * noise.rotation_sigma_rad;
  innovation.diagonal().tail<3>().array() += noise.position_sigma_m * noise.position_sigma_m;
  const Eigen::Matrix<double, kImuDim, 6> gain =
      innovation.ldlt().solve(state.covariance.topRows<6>()).transpose();
  MoveBy(gain * residual, &state.mean);
  const Matrix15d covariance = state.covariance - gain * innovation * gain.transpose();
  state.covariance = 0.5 * (covariance + covariance.transpose());
  return state;
}

std::vector<FilteredPose> FilterForward(const Trajectory& trajectory,
                                        const std::vector<Knot>& knots, const PoseNoise& pose_noise,
                                        const ImuNoise& imu_noise) {
  ImuBuffer buffer(static_cast<int>(trajectory.imu.size()));
  for (const ImuSample& sample : trajectory.imu) {
    buffer.Push(sample);
  }
  std::vector<FilteredPose> filtered(knots.size());
  filtered.front().predicted = Start(trajectory);
  for (size_t i = 0; i < filtered.size(); ++i) {
    if (i > 0) {
      filtered[i].predicted = filtered[i - 1].updated;
      Predict(buffer, knots[i - 1].timestamp_ns, knots[i].timestamp_ns, imu_noise,
              trajectory.gravity_m_s2, &filtered[i]);
    }
    filtered[i].updated = knots[i].captured
                              ? Updated(filtered[i].predicted, *knots[i].captured, pose_noise)
                              : filtered[i].predicted;
  }
  return filtered;
}

}  // namespace

void SmoothPoses(const PoseNoise& pose_noise, const ImuNoise& imu_noise, Trajectory* trajectory) {
  if (!(pose_noise.position_sigma_m > 0.0 && pose_noise.rotation_sigma_rad > 0.0)) {
    throw Error(ErrorCode::kInvalidArgument, "PoseNoise: standard deviations must be positive");
  }
  std::erase_if(trajectory->poses, [&](const TruePose& pose) {
    return trajectory->imu.empty() || pose.timestamp_ns < trajectory->imu.front().timestamp_ns ||
           pose.timestamp_ns > trajectory->imu.back().timestamp_ns;
  });
  if (trajectory->poses.size() < 2) {
    throw Error(ErrorCode::kBadInput,
                "trajectory " + trajectory->name + ": fewer than two poses within the samples");
  }
  const std::vector<Knot> knots = Knots(*trajectory);
  const std::vector<FilteredPose> filtered =
      FilterForward(*trajectory, knots, pose_noise, imu_noise);
  ImuState smoothed = filtered.back().updated.mean;
  trajectory->poses.resize(knots.size());
  trajectory->poses.back() = {knots.back().timestamp_ns, smoothed.local_from_imu};
  for (size_t i = filtered.size() - 1; i-- > 0;) {
    // Rauch-Tung-Striebel: gain P_i Phi' (P_i+1 predicted)^-1.
    const FilteredPose& next = filtered[i + 1];
    const Vector15d error =
        filtered[i].updated.covariance * next.from_previous.transpose() *
        next.predicted.covariance.ldlt().solve(Difference(smoothed, next.predicted.mean));
    smoothed = filtered[i].updated.mean;
    MoveBy(error, &smoothed);
    trajectory->poses[i] = {knots[i].timestamp_ns, smoothed.local_from_imu};
  }
  trajectory->gyro_bias = smoothed.gyro_bias;
  trajectory->accel_bias = smoothed.accel_bias;
}

}  // namespace cairn::fusion
