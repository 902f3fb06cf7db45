#include "fusion/start/dynamic_start.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/require.h"
#include "core/rotation_between.h"
#include "fusion/filter/chi_square.h"

namespace cairn::fusion {
namespace {

// Fewest tracks of a start.
constexpr int kMinTracks = 20;

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

// The pose that the IMU would have at each frame without gravity and initial velocity, in the IMU's
// frame at the first frame.
std::vector<Rigid3d> Preintegrate(const DynamicStartInput& input,
                                  const Eigen::Vector3d& gyro_bias) {
  ImuState state;
  state.gyro_bias = gyro_bias;
  std::vector<Rigid3d> poses = {state.local_from_imu};
  for (size_t i = 1; i < input.frames.size(); ++i) {
    input.imu.ForEachStep(
        input.frames[i - 1].timestamp_ns, input.frames[i].timestamp_ns,
        [&state](const ImuStep& step) { state = IntegrateImu(state, step, 0.0); });
    poses.push_back(state.local_from_imu);
  }
  return poses;
}

// The observations that a track has in the frames of the window, each with the index of its frame.
std::vector<std::pair<size_t, const Observation*>> ObservationsInWindow(
    const DynamicStartInput& input, const Track& track) {
  std::vector<std::pair<size_t, const Observation*>> observations;
  size_t frame = 0;
  for (const Observation& observation : track.observations) {
    while (frame < input.frames.size() && input.frames[frame].frame_id < observation.frame_id) {
      ++frame;
    }
    if (frame < input.frames.size() && input.frames[frame].frame_id == observation.frame_id) {
      observations.emplace_back(frame, &observation);
    }
  }
  return observations;
}

// Returns the g of magnitude `gravity_m_s2` that minimizes g' S g / 2 - s' g, by solving (S +
// lambda I) g = s.
std::optional<Eigen::Vector3d> GravityOfSize(const Eigen::Matrix3d& quadratic,
                                             const Eigen::Vector3d& linear, double gravity_m_s2) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(quadratic);
  const Eigen::Vector3d values = eigen.eigenvalues();
  const Eigen::Vector3d along = eigen.eigenvectors().transpose() * linear;
  const auto at = [&](double lambda) -> Eigen::Vector3d {
    return along.array() / (values.array() + lambda);
  };
  // The magnitude of g falls from infinity to zero as lambda grows from minus the smallest
  // eigenvalue.
  double low = -values[0];
  double high = low + linear.norm() / gravity_m_s2 + 1.0;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (at(middle).norm() > gravity_m_s2 ? low : high) = middle;
  }
  const Eigen::Vector3d gravity = eigen.eigenvectors() * at(high);
  if (!(std::abs(gravity.norm() / gravity_m_s2 - 1.0) < 0.01)) {
    return std::nullopt;
  }
  return gravity;
}

// Normal equations for [velocity, gravity]. They state that the rays of each track meet.
struct LinearSystem {
  Matrix6 normal = Matrix6::Zero();
  Vector6 right = Vector6::Zero();
  int num_tracks = 0;
};

LinearSystem RaysMeet(const DynamicStartInput& input, const Eigen::Vector3d& gyro_bias) {
  const std::vector<Rigid3d> poses = Preintegrate(input, gyro_bias);
  const Rigid3d imu_from_cam = input.rig.cam_from_imu.Inverse();
  LinearSystem system;
  for (const Track& track : input.tracks.tracks()) {
    const auto observations = ObservationsInWindow(input, track);
    if (observations.size() < 3) {
      continue;
    }
    // Columns: point, velocity, gravity, right side.
    Eigen::MatrixXd rows(3 * static_cast<Eigen::Index>(observations.size()), 10);
    Eigen::Index row = 0;
    for (const auto& [frame, observation] : observations) {
      const Rigid3d first_from_cam = poses[frame] * imu_from_cam;
      const Eigen::Vector3d ray = first_from_cam.rotation * observation->ray_in_cam;
      const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - ray * ray.transpose();
      const double time_s = 1e-9 * static_cast<double>(input.frames[frame].timestamp_ns -
                                                       input.frames[0].timestamp_ns);
      rows.middleRows<3>(row) << across, -time_s * across, -0.5 * time_s * time_s * across,
          across * first_from_cam.translation;
      row += 3;
    }
    Triangularize(3, rows);
    const Eigen::MatrixXd rest = rows.bottomRightCorner(rows.rows() - 3, 7);
    system.normal.noalias() += rest.leftCols<6>().transpose() * rest.leftCols<6>();
    system.right.noalias() += rest.leftCols<6>().transpose() * rest.col(6);
    ++system.num_tracks;
  }
  return system;
}

// The linearization point of the window: the state at its first frame.
struct StartGuess {
  Eigen::Quaterniond local_from_imu;
  Eigen::Vector3d velocity_in_local;
  Eigen::Vector3d gyro_bias;
};

StartGuess GuessFrom(const LinearStart& linear, const Eigen::Vector3d& gyro_bias) {
  const Eigen::Quaterniond local_from_imu =
      RotationBetween(-linear.gravity_in_imu, Eigen::Vector3d::UnitZ());
  return {local_from_imu, local_from_imu * linear.velocity_in_imu, gyro_bias};
}

// Integrates backwards from the state at the last frame to the first frame.
StartGuess GuessFrom(const DynamicStartInput& input, const FilterState& state) {
  ImuState imu = state.imu();
  imu.local_from_imu = state.clones().front().local_from_imu;
  imu.velocity_in_local.setZero();
  input.imu.ForEachStep(
      input.frames.front().timestamp_ns, input.frames.back().timestamp_ns,
      [&](const ImuStep& step) { imu = IntegrateImu(imu, step, input.gravity_m_s2); });
  return {state.clones().front().local_from_imu.rotation,
          state.imu().velocity_in_local - imu.velocity_in_local, state.imu().gyro_bias};
}

// The state before the window's tracks are used: at the origin, with wide priors on everything but
// the accelerometer bias.
FilterState PriorState(const DynamicStartInput& input, const StartGuess& guess) {
  // Prior standard deviations of the biases: the usual range of such sensors.
  constexpr double kGyroBiasSigmaRadS = 0.02;
  constexpr double kAccelBiasSigmaMS2 = 0.1;
  ImuState imu;
  imu.local_from_imu.rotation = guess.local_from_imu;
  imu.velocity_in_local = guess.velocity_in_local;
  imu.gyro_bias = guess.gyro_bias;
  Eigen::Matrix<double, kImuDim, 1> sigma = Eigen::Matrix<double, kImuDim, 1>::Zero();
  sigma.head<2>().setConstant(0.3);  // Radians; wide compared with the tracks' information.
  sigma.segment<3>(kVelocityIdx).setConstant(std::max(1.0, guess.velocity_in_local.norm()));
  sigma.segment<3>(kGyroBiasIdx).setConstant(kGyroBiasSigmaRadS);
  sigma.segment<3>(kAccelBiasIdx).setConstant(kAccelBiasSigmaMS2);
  FilterStateOptions state_options;
  state_options.max_points = 0;
  return {imu, sigma.cwiseAbs2().asDiagonal(), input.rig, state_options};
}

// Propagates the state over the window and adds a clone at each frame.
void CloneAllFrames(const DynamicStartInput& input, FilterState* state) {
  for (size_t i = 0; i < input.frames.size(); ++i) {
    if (i > 0) {
      ImuState end = state->imu();
      FirstEstimate first = state->first();
      ImuTransition transition;
      input.imu.ForEachStep(
          input.frames[i - 1].timestamp_ns, input.frames[i].timestamp_ns, [&](const ImuStep& step) {
            Propagate(step, input.imu_noise, input.gravity_m_s2, &end, &first, &transition);
          });
      state->Propagate(end, first, transition);
    }
    state->AddClone(input.frames[i].frame_id, input.frames[i].timestamp_ns,
                    Eigen::Vector3d::Zero());
  }
}

// Linearizes all tracks that can be triangulated. If `gates` is set, leaves out those that
// contradict the state. `num_tried` receives the number of triangulated tracks.
std::vector<TrackRows> UsableTracks(const DynamicStartInput& input, const FilterState& state,
                                    bool gates, int* num_tried) {
  const std::vector<CameraView> views = ViewsOfClones(state);
  std::vector<TrackRows> usable;
  *num_tried = 0;
  for (const Track& track : input.tracks.tracks()) {
    std::vector<Observation> observations;
    for (const auto& [frame, observation] : ObservationsInWindow(input, track)) {
      observations.push_back(*observation);
    }
    auto rows = static_cast<int>(observations.size()) < kMinTrackViews
                    ? std::nullopt
                    : LinearizeTrack(state, input.camera, views, observations, input.track_options);
    if (!rows) {
      continue;
    }
    ++*num_tried;
    if (!gates ||
        state.SquaredMahalanobis(rows->clones) < ChiSquareQuantile(rows->clones.num_rows(), 3.09)) {
      usable.push_back(std::move(*rows));
    }
  }
  return usable;
}

// The IMU's part of the state, expressed in a local frame in which the IMU is at the origin with
// yaw zero.
StartState AtOrigin(const FilterState& state) {
  const ImuState& imu = state.imu();
  const Eigen::Matrix3d rotation = imu.local_from_imu.rotation.toRotationMatrix();
  Eigen::Vector3d ahead = rotation.col(0);
  if (ahead.head<2>().norm() < 0.5) {
    ahead = rotation.col(2);
  }
  const Eigen::Quaterniond turn = ExpSo3({0.0, 0.0, -std::atan2(ahead.y(), ahead.x())});
  // The new local frame absorbs the errors of yaw and position. This Jacobian maps the old error to
  // the part that remains.
  Matrix15d jacobian = Matrix15d::Identity();
  jacobian(kThetaIdx + 2, kThetaIdx + 2) = 0.0;
  jacobian.block<3, 3>(kPositionIdx, kPositionIdx).setZero();
  jacobian.block<3, 1>(kVelocityIdx, kThetaIdx + 2) =
      -Eigen::Vector3d::UnitZ().cross(imu.velocity_in_local);
  Matrix15d turned = Matrix15d::Identity();
  for (const int offset : {kThetaIdx, kPositionIdx, kVelocityIdx}) {
    turned.block<3, 3>(offset, offset) = turn.toRotationMatrix();
  }
  jacobian = (turned * jacobian).eval();
  StartState start;
  start.imu = imu;
  start.imu.local_from_imu =
      Rigid3d((turn * imu.local_from_imu.rotation).normalized(), Eigen::Vector3d::Zero());
  start.imu.velocity_in_local = turn * imu.velocity_in_local;
  start.covariance =
      jacobian * state.covariance().topLeftCorner<kImuDim, kImuDim>() * jacobian.transpose();
  return start;
}

// Returns true if the standard deviations of the start are below the limits of a usable one.
bool IsGood(const StartState& start) {
  constexpr double kMaxTiltSigmaRad = 0.05;
  constexpr double kMaxVelocitySigmaMS = 0.15;
  const auto variance = start.covariance.diagonal();
  return start.covariance.allFinite() &&
         std::sqrt(variance.segment<2>(kThetaIdx).maxCoeff()) < kMaxTiltSigmaRad &&
         std::sqrt(variance.segment<3>(kVelocityIdx).maxCoeff()) < kMaxVelocitySigmaMS;
}

}  // namespace

void DynamicStartOptions::Validate() const {
  RequireOption(window_s > 0.0, "dynamic_start.window_s must be positive");
}

std::optional<LinearStart> SolveLinearStart(const DynamicStartInput& input,
                                            const Eigen::Vector3d& gyro_bias) {
  const LinearSystem system = RaysMeet(input, gyro_bias);
  if (system.num_tracks < kMinTracks) {
    return std::nullopt;
  }
  const Eigen::Matrix3d by_velocity = system.normal.topLeftCorner<3, 3>();
  const Eigen::LDLT<Eigen::Matrix3d> ldlt(by_velocity);
  const Eigen::Matrix3d coupling = system.normal.topRightCorner<3, 3>();
  const Eigen::Matrix3d eliminated = ldlt.solve(coupling);
  const Eigen::Matrix3d quadratic =
      system.normal.bottomRightCorner<3, 3>() - coupling.transpose() * eliminated;
  const Eigen::Vector3d linear =
      system.right.tail<3>() - eliminated.transpose() * system.right.head<3>();
  const auto gravity = GravityOfSize(quadratic, linear, input.gravity_m_s2);
  if (!gravity) {
    return std::nullopt;
  }
  const Eigen::Vector3d velocity = ldlt.solve(system.right.head<3>() - coupling * *gravity);
  if (!velocity.allFinite()) {
    return std::nullopt;
  }
  return LinearStart{velocity, *gravity};
}

std::optional<StartState> DynamicStart(const DynamicStartInput& input) {
  constexpr size_t kMinFrames = 6;
  constexpr double kMinInlierFraction = 0.7;  // Share of the tracks that must agree.
  if (input.frames.size() < kMinFrames) {
    return std::nullopt;
  }
  // The first pass linearizes at the linear solution, which assumes known biases. Each later pass
  // linearizes at the result of the previous one.
  constexpr int kNumPasses = 3;
  const auto linear = SolveLinearStart(input, Eigen::Vector3d::Zero());
  if (!linear) {
    return std::nullopt;
  }
  StartGuess guess = GuessFrom(*linear, Eigen::Vector3d::Zero());
  std::optional<FilterState> state;
  for (int pass = 0; pass < kNumPasses; ++pass) {
    state.emplace(PriorState(input, guess));
    CloneAllFrames(input, &*state);
    int num_tried = 0;
    const auto linearize = [&](const FilterState& at) {
      return StackTracks(at, UsableTracks(input, at, false, &num_tried));
    };
    if (!state->IteratedUpdate(linearize) || num_tried < kMinTracks) {
      return std::nullopt;
    }
    guess = GuessFrom(input, *state);
  }
  int num_tried = 0;
  const size_t num_agreeing = UsableTracks(input, *state, true, &num_tried).size();
  if (static_cast<double>(num_agreeing) < kMinInlierFraction * num_tried) {
    return std::nullopt;
  }
  const StartState start = AtOrigin(*state);
  return IsGood(start) ? std::optional(start) : std::nullopt;
}

}  // namespace cairn::fusion
