#include "fusion/simulation.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/angles.h"
#include "eval/recordings/measure_motion.h"

namespace cairn::fusion::testing {
namespace {

constexpr double kGravity = 9.81;
// Of the field of view.
constexpr double kMaxTangentX = 0.68;
constexpr double kMaxTangentY = 0.51;

Eigen::Vector3d Gaussian(std::mt19937_64* random, double sigma) {
  std::normal_distribution<double> normal;
  const double x = normal(*random);
  const double y = normal(*random);
  const double z = normal(*random);
  return sigma * Eigen::Vector3d(x, y, z);
}

double Uniform(std::mt19937_64* random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(*random);
}

double YawRad(const Eigen::Quaterniond& rotation) {
  const Eigen::Matrix3d matrix = rotation.toRotationMatrix();
  return std::atan2(matrix(1, 0), matrix(0, 0));
}

// Ahead is the imu's x axis; the camera sits 5 cm before and 3 cm beside it.
Rig SimulatedRig() {
  Eigen::Matrix3d cam_from_imu;
  cam_from_imu << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  return {Rigid3d(cam_from_imu, Eigen::Vector3d(0.03, 0.01, -0.05)), 0.0};
}

}  // namespace

Simulation::Simulation(const SimulationOptions& options)
    : options_(options),
      camera_(CameraModel::kPinhole, 640, 480, {460.0, 460.0, 320.0, 240.0}),
      rig_(SimulatedRig()),
      random_(options.seed) {
  const std::vector<FrameTruth> frames = WalkAndMeasure();
  ScatterLandmarks(frames);
  TrackLandmarks(frames);
}

Simulation::Simulation(const SimulationOptions& options, std::vector<ImuSample> imu,
                       const std::vector<FrameTruth>& frames)
    : options_(options),
      camera_(CameraModel::kPinhole, 640, 480, {460.0, 460.0, 320.0, 240.0}),
      rig_(SimulatedRig()),
      random_(options.seed),
      imu_(std::move(imu)) {
  ScatterLandmarks(frames);
  TrackLandmarks(frames);
}

std::vector<FrameTruth> Simulation::WalkAndMeasure() {
  const FigureOfEight path(options_.walk);
  const int num_samples = static_cast<int>(options_.duration_s * options_.imu_rate_hz) + 2;
  InertialWalk walk = MeasureMotion([&path](double time_s) { return path.At(time_s); }, num_samples,
                                    {.rate_hz = options_.imu_rate_hz,
                                     .noise = options_.imu_noise,
                                     .gyro_bias = options_.gyro_bias,
                                     .accel_bias = options_.accel_bias,
                                     .gravity_m_s2 = kGravity},
                                    [this](int64_t) { return Gaussian(&random_, 1.0); });
  const auto samples_per_frame =
      static_cast<size_t>(std::lround(options_.imu_rate_hz / options_.frame_rate_hz));
  std::vector<FrameTruth> frames;
  for (size_t i = 0; i < walk.truth.size(); i += samples_per_frame) {
    const ImuState& truth = walk.truth[i];
    frames.push_back({walk.imu[i].timestamp_ns, truth.local_from_imu, truth.velocity_in_local,
                      truth.gyro_bias, truth.accel_bias});
  }
  imu_ = std::move(walk.imu);
  return frames;
}

void Simulation::ScatterLandmarks(const std::vector<FrameTruth>& frames) {
  if (options_.max_depth_m > 0.0) {
    ScatterLandmarksInView(frames);
    return;
  }
  double length_m = 0.0;
  for (size_t i = 1; i < frames.size(); ++i) {
    length_m +=
        (frames[i].world_from_imu.translation - frames[i - 1].world_from_imu.translation).norm();
  }
  const int num_landmarks =
      std::max(1500, static_cast<int>(length_m * options_.landmarks_per_meter));
  for (int i = 0; i < num_landmarks; ++i) {
    const size_t at = std::uniform_int_distribution<size_t>(0, frames.size() - 1)(random_);
    const double azimuth = Uniform(&random_, 0.0, 2.0 * kPi);
    const double distance_m = Uniform(&random_, 4.0, 16.0);
    landmarks_.push_back(frames[at].world_from_imu.translation +
                         Eigen::Vector3d(distance_m * std::cos(azimuth),
                                         distance_m * std::sin(azimuth),
                                         Uniform(&random_, -1.6, 4.0)));
  }
}

void Simulation::ScatterLandmarksInView(const std::vector<FrameTruth>& frames) {
  for (const FrameTruth& truth : frames) {
    const Rigid3d cam_from_world = rig_.cam_from_imu * truth.world_from_imu.Inverse();
    const auto num_features = static_cast<size_t>(options_.num_features);
    for (size_t i = VisibleLandmarks(cam_from_world).size(); i < num_features; ++i) {
      const double x = Uniform(&random_, -kMaxTangentX, kMaxTangentX);
      const double y = Uniform(&random_, -kMaxTangentY, kMaxTangentY);
      const double depth_m = Uniform(&random_, options_.min_depth_m, options_.max_depth_m);
      landmarks_.push_back(cam_from_world.Inverse() *
                           Eigen::Vector3d(x * depth_m, y * depth_m, depth_m));
    }
  }
}

std::vector<int> Simulation::VisibleLandmarks(const Rigid3d& cam_from_world) const {
  const Eigen::Matrix3d rotation = cam_from_world.rotation.toRotationMatrix();
  const double max_depth_m = options_.max_depth_m > 0.0 ? options_.max_depth_m : 25.0;
  std::vector<int> visible;
  for (size_t i = 0; i < landmarks_.size(); ++i) {
    const Eigen::Vector3d x = rotation * landmarks_[i] + cam_from_world.translation;
    if (x.z() > 1.0 && x.z() < max_depth_m && std::abs(x.x()) < kMaxTangentX * x.z() &&
        std::abs(x.y()) < kMaxTangentY * x.z()) {
      visible.push_back(static_cast<int>(i));
    }
  }
  return visible;
}

void Simulation::TrackLandmarks(const std::vector<FrameTruth>& frames) {
  std::unordered_map<int, uint64_t> tracked;  // Track of a landmark.
  uint64_t next_track_id = 1;
  std::normal_distribution<double> pixel_noise(0.0, options_.pixel_sigma_px);
  for (const FrameTruth& truth : frames) {
    const Rigid3d cam_from_world = rig_.cam_from_imu * truth.world_from_imu.Inverse();
    std::vector<int> visible = VisibleLandmarks(cam_from_world);
    std::unordered_map<int, uint64_t> kept;
    std::vector<int> chosen;
    std::vector<int> others;
    for (const int landmark : visible) {
      const auto track = tracked.find(landmark);
      const bool keeps =
          track != tracked.end() && Uniform(&random_, 0.0, 1.0) > options_.track_loss;
      if (keeps) {
        kept.emplace(*track);
      }
      (keeps ? chosen : others).push_back(landmark);
    }
    std::shuffle(others.begin(), others.end(), random_);
    for (size_t i = 0;
         i < others.size() && chosen.size() < static_cast<size_t>(options_.num_features); ++i) {
      chosen.push_back(others[i]);
      landmark_of_track_.emplace(next_track_id, others[i]);
      kept.emplace(others[i], next_track_id++);
    }
    tracked = std::move(kept);
    SimulatedFrame frame{truth, {}};
    for (const int landmark : chosen) {
      Eigen::Vector2d pixel =
          *camera_.Project(cam_from_world * landmarks_[static_cast<size_t>(landmark)]);
      const double dx = pixel_noise(random_);
      const double dy = pixel_noise(random_);
      pixel += Eigen::Vector2d(dx, dy);
      if (Uniform(&random_, 0.0, 1.0) < options_.outlier_fraction) {
        pixel += Eigen::Vector2d(Uniform(&random_, -30.0, 30.0), Uniform(&random_, -30.0, 30.0));
      }
      frame.features.push_back({tracked.at(landmark), pixel});
    }
    frames_.push_back(std::move(frame));
  }
}

FusionOptions Simulation::MatchingFusionOptions() const {
  FusionOptions options;
  options.camera = camera_;
  options.rig = rig_;
  options.imu_noise = options_.imu_noise;
  options.gravity_m_s2 = kGravity;
  options.tracks.sigma_px = options_.pixel_sigma_px;
  options.map.sigma_px = options_.pixel_sigma_px;
  options.state.tile_sigma_m = options_.tile_sigma_m;
  return options;
}

Rigid3d Simulation::LocalFromWorld(size_t frame) const {
  const Rigid3d& world_from_imu = frames_[frame].truth.world_from_imu;
  const Eigen::Quaterniond turn(
      Eigen::AngleAxisd(-YawRad(world_from_imu.rotation), Eigen::Vector3d::UnitZ()));
  return Rigid3d(turn, -(turn * world_from_imu.translation));
}

StartState Simulation::DrawStart(size_t frame, uint64_t seed) const {
  std::mt19937_64 random(seed * 7919 + 17);
  const FrameTruth& truth = frames_[frame].truth;
  const Rigid3d local_from_world = LocalFromWorld(frame);
  Eigen::Matrix<double, kImuDim, 1> sigma;
  sigma << 0.01, 0.01, 0.0, Eigen::Vector3d::Zero(), Eigen::Vector3d::Constant(0.05),
      Eigen::Vector3d::Constant(0.002), Eigen::Vector3d::Constant(0.03);
  std::normal_distribution<double> normal;
  Eigen::Matrix<double, kImuDim, 1> error;
  for (int i = 0; i < kImuDim; ++i) {
    error[i] = sigma[i] * normal(random);
  }
  StartState start;
  start.covariance = sigma.cwiseAbs2().asDiagonal();
  const Rigid3d local_from_imu = local_from_world * truth.world_from_imu;
  start.imu.local_from_imu =
      Rigid3d(ExpSo3(-error.head<3>()) * local_from_imu.rotation, local_from_imu.translation);
  start.imu.velocity_in_local =
      local_from_world.rotation * truth.velocity_in_world - error.segment<3>(kVelocityIdx);
  start.imu.gyro_bias = truth.gyro_bias - error.segment<3>(kGyroBiasIdx);
  start.imu.accel_bias = truth.accel_bias - error.segment<3>(kAccelBiasIdx);
  return start;
}

StartState Simulation::TrueStart(size_t frame) const {
  const FrameTruth& truth = frames_[frame].truth;
  const Rigid3d local_from_world = LocalFromWorld(frame);
  StartState start;
  start.imu = {local_from_world * truth.world_from_imu,
               local_from_world.rotation * truth.velocity_in_world, truth.gyro_bias,
               truth.accel_bias};
  Eigen::Matrix<double, kImuDim, 1> sigma;
  sigma << 0.02, 0.02, 0.0, Eigen::Vector3d::Zero(), Eigen::Vector3d::Constant(0.01),
      Eigen::Vector3d::Constant(0.02), Eigen::Vector3d::Constant(0.02);
  start.covariance = sigma.cwiseAbs2().asDiagonal();
  return start;
}

uint64_t Simulation::TileOf(const Eigen::Vector3d& x_in_world) const {
  const auto east = static_cast<int64_t>(std::floor(x_in_world.x() / options_.tile_size_m));
  const auto north = static_cast<int64_t>(std::floor(x_in_world.y() / options_.tile_size_m));
  return static_cast<uint64_t>((east + 1000) * 10000 + north + 1000);
}

Eigen::Vector3d Simulation::MapPosition(int landmark) const {
  const Eigen::Vector3d& truth = landmarks_[static_cast<size_t>(landmark)];
  std::mt19937_64 tile_random(options_.seed * 104729 + TileOf(truth));
  std::mt19937_64 landmark_random(options_.seed * 1299709 + static_cast<uint64_t>(landmark));
  return truth + Gaussian(&tile_random, options_.tile_sigma_m) +
         Gaussian(&landmark_random, options_.map_sigma_m);
}

size_t Simulation::FrameOfQuery(const Query& query) const {
  const auto found = std::lower_bound(frames_.begin(), frames_.end(), query.timestamp_ns,
                                      [](const SimulatedFrame& frame, int64_t timestamp_ns) {
                                        return frame.truth.timestamp_ns < timestamp_ns;
                                      });
  return static_cast<size_t>(found - frames_.begin());
}

Answer Simulation::MakeAnswer(const Query& query, size_t frame,
                              const AnswerOptions& options) const {
  std::mt19937_64 random(options_.seed * 31 + static_cast<uint64_t>(query.query_id));
  Answer answer;
  answer.query_id = query.query_id;
  answer.localized = true;
  const Rigid3d world_from_cam = frames_[frame].truth.world_from_imu * rig_.cam_from_imu.Inverse();
  answer.global_from_cam =
      options.global_from_true_global *
      Rigid3d(world_from_cam.rotation * ExpSo3(Gaussian(&random, 0.003)),
              world_from_cam.translation + Gaussian(&random, 0.05 + options_.map_sigma_m));
  for (const TrackedFeature& feature : query.features) {
    if (static_cast<int>(answer.matches.size()) == options.max_matches) {
      break;
    }
    int landmark = landmark_of_track_.at(feature.track_id);
    if (Uniform(&random, 0.0, 1.0) < options.wrong_fraction) {
      landmark =
          std::uniform_int_distribution<int>(0, static_cast<int>(landmarks_.size()) - 1)(random);
    }
    answer.matches.push_back({feature.pixel, feature.track_id,
                              options.global_from_true_global * MapPosition(landmark),
                              options_.map_sigma_m, static_cast<uint64_t>(landmark) + 1,
                              TileOf(landmarks_[static_cast<size_t>(landmark)])});
  }
  return answer;
}

Simulation SimulateWalk(double duration_s, uint64_t seed) {
  SimulationOptions options;
  options.seed = seed;
  options.walk.seed = seed;
  options.duration_s = duration_s;
  return Simulation(options);
}

}  // namespace cairn::fusion::testing
