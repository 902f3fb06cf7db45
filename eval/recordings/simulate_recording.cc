#include "eval/recordings/simulate_recording.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <unordered_map>

#include "core/angles.h"
#include "core/error.h"
#include "core/require.h"
#include "eval/recordings/trajectory_interpolation.h"

namespace cairn::fusion {
namespace {

// Error of the server's own pose, from which the first alignment starts.
constexpr double kAnswerRotationSigmaRad = 0.003;
constexpr double kAnswerPositionSigmaM = 0.05;

Eigen::Vector3d DrawGaussian(double sigma, std::mt19937_64* random) {
  std::normal_distribution<double> normal;
  const double x = normal(*random);
  const double y = normal(*random);
  const double z = normal(*random);
  return sigma * Eigen::Vector3d(x, y, z);
}

class Simulator {
 public:
  Simulator(const Trajectory& trajectory, const RecordingOptions& options)
      : trajectory_(trajectory), options_(options), random_(options.seed) {}

  Recording Run() {
    Recording recording;
    recording.name = trajectory_.name;
    recording.options = MatchingFusionOptions();
    recording.imu = trajectory_.imu;
    recording.frames_per_query = options_.frames_per_query;
    recording.first_counted_frame =
        static_cast<size_t>(options_.first_counted_s * options_.frame_rate_hz);
    for (const int64_t timestamp_ns : FrameTimes()) {
      RecordedFrame frame;
      frame.timestamp_ns = timestamp_ns;
      frame.global_from_imu = PoseAt(trajectory_.poses, timestamp_ns);
      recording.frames.push_back(std::move(frame));
    }
    if (recording.frames.size() < 2) {
      throw Error(ErrorCode::kBadInput, "trajectory " + trajectory_.name +
                                            ": too short for two frames within poses and samples");
    }
    recording.start = DrawStart(TruthAt(recording.frames.front()), options_, &random_);
    ScatterLandmarks(recording.frames);
    for (size_t i = 0; i < recording.frames.size(); ++i) {
      Track(&recording.frames[i]);
      if (i > 0 && i % static_cast<size_t>(options_.frames_per_query) == 0) {
        MakeAnswer(&recording.frames[i]);
      }
    }
    return recording;
  }

 private:
  FusionOptions MatchingFusionOptions() const {
    FusionOptions options;
    options.camera = options_.camera;
    options.rig = options_.rig;
    options.imu_noise = options_.imu_noise;
    options.gravity_m_s2 = trajectory_.gravity_m_s2;
    options.tracks.sigma_px = options_.track_sigma_px;
    options.map.sigma_px = options_.match_sigma_px;
    return options;
  }

  std::vector<int64_t> FrameTimes() const {
    std::vector<int64_t> times;
    if (trajectory_.imu.size() < 2 || trajectory_.poses.size() < 2) {
      return times;
    }
    const int64_t begin_ns =
        std::max(trajectory_.imu.front().timestamp_ns, trajectory_.poses.front().timestamp_ns);
    const int64_t end_ns =
        std::min(trajectory_.imu.back().timestamp_ns, trajectory_.poses.back().timestamp_ns);
    const auto period_ns = static_cast<int64_t>(std::llround(1e9 / options_.frame_rate_hz));
    const auto last_ns = begin_ns + static_cast<int64_t>(1e9 * options_.duration_s);
    for (int64_t t = begin_ns; t <= std::min(end_ns, last_ns); t += period_ns) {
      times.push_back(t);
    }
    return times;
  }

  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  Eigen::Vector3d Gaussian(double sigma) { return DrawGaussian(sigma, &random_); }

  ImuState TruthAt(const RecordedFrame& frame) const {
    ImuState truth;
    truth.local_from_imu = frame.global_from_imu;
    truth.velocity_in_local = VelocityAt(trajectory_.poses, frame.timestamp_ns);
    truth.gyro_bias = trajectory_.gyro_bias;
    truth.accel_bias = trajectory_.accel_bias;
    return truth;
  }

  void ScatterLandmarks(const std::vector<RecordedFrame>& frames) {
    for (int i = 0; i < options_.num_landmarks; ++i) {
      const size_t at = std::uniform_int_distribution<size_t>(0, frames.size() - 1)(random_);
      const double azimuth = Uniform(0.0, 2.0 * kPi);
      const double distance_m = Uniform(options_.min_distance_m, options_.max_distance_m);
      const double height_m = Uniform(options_.min_height_m, options_.max_height_m);
      landmarks_.push_back(frames[at].global_from_imu.translation +
                           Eigen::Vector3d(distance_m * std::cos(azimuth),
                                           distance_m * std::sin(azimuth), height_m));
      in_map_.push_back(landmarks_.back() + Gaussian(options_.map_sigma_m));
    }
  }

  // Returns the landmarks in view with their pixels.
  std::vector<std::pair<int, Eigen::Vector2d>> Visible(const Rigid3d& cam_from_global) const {
    const Eigen::Matrix3d rotation = cam_from_global.rotation.toRotationMatrix();
    std::vector<std::pair<int, Eigen::Vector2d>> visible;
    for (size_t i = 0; i < landmarks_.size(); ++i) {
      const Eigen::Vector3d x = rotation * landmarks_[i] + cam_from_global.translation;
      if (x.z() < 0.5 || x.z() > 1.6 * options_.max_distance_m) {
        continue;
      }
      const auto pixel = options_.camera.Project(x);
      if (pixel && options_.camera.Contains(*pixel)) {
        visible.emplace_back(static_cast<int>(i), *pixel);
      }
    }
    return visible;
  }

  // Tracks that continue come first. New tracks are drawn from the other landmarks in view.
  void Track(RecordedFrame* frame) {
    auto visible = Visible(options_.rig.cam_from_imu * frame->global_from_imu.Inverse());
    std::shuffle(visible.begin(), visible.end(), random_);
    std::erase_if(track_of_landmark_,
                  [&](const auto&) { return Uniform(0.0, 1.0) < options_.track_loss; });
    std::stable_partition(visible.begin(), visible.end(), [&](const auto& observation) {
      return track_of_landmark_.contains(observation.first);
    });
    std::map<int, uint64_t> kept;
    std::normal_distribution<double> noise(0.0, options_.track_sigma_px);
    for (const auto& [landmark, pixel] : visible) {
      if (static_cast<int>(frame->features.size()) == options_.max_features) {
        break;
      }
      const auto track = track_of_landmark_.find(landmark);
      const uint64_t id = track != track_of_landmark_.end() ? track->second : next_track_id_++;
      kept.emplace(landmark, id);
      landmark_of_track_[id] = landmark;
      const double dx = noise(random_);
      const double dy = noise(random_);
      frame->features.push_back({id, pixel + Eigen::Vector2d(dx, dy)});
    }
    track_of_landmark_ = std::move(kept);
  }

  void MakeAnswer(RecordedFrame* frame) {
    Answer& answer = frame->answer;
    answer.localized = true;
    const Rigid3d global_from_cam = frame->global_from_imu * options_.rig.cam_from_imu.Inverse();
    answer.global_from_cam =
        Rigid3d(global_from_cam.rotation * ExpSo3(Gaussian(kAnswerRotationSigmaRad)),
                global_from_cam.translation + Gaussian(kAnswerPositionSigmaM));
    for (const TrackedFeature& feature : frame->features) {
      if (static_cast<int>(answer.matches.size()) == options_.max_matches) {
        break;
      }
      size_t landmark = static_cast<size_t>(landmark_of_track_.at(feature.track_id));
      if (Uniform(0.0, 1.0) < options_.wrong_match_fraction) {
        landmark = std::uniform_int_distribution<size_t>(0, landmarks_.size() - 1)(random_);
      }
      answer.matches.push_back({.pixel = feature.pixel,
                                .track_id = feature.track_id,
                                .x_in_global = in_map_[landmark],
                                .sigma_m = options_.map_sigma_m,
                                .landmark_id = landmark + 1});
    }
  }

  const Trajectory& trajectory_;
  const RecordingOptions& options_;
  std::mt19937_64 random_;
  std::vector<Eigen::Vector3d> landmarks_;
  std::vector<Eigen::Vector3d> in_map_;        // Landmark positions in the map.
  std::map<int, uint64_t> track_of_landmark_;  // Of the last frame.
  std::unordered_map<uint64_t, int> landmark_of_track_;
  uint64_t next_track_id_ = 1;
};

}  // namespace

void RecordingOptions::Validate() const {
  RequireOption(rig.time_offset_s == 0.0, "recording.rig.time_offset_s must be 0");
  RequireOption(duration_s > 0.0 && frame_rate_hz > 0.0,
                "recording.duration_s and frame_rate_hz must be positive");
  RequireOption(frames_per_query >= 1, "recording.frames_per_query must be positive");
  RequireOption(first_counted_s >= 0.0, "recording.first_counted_s must not be negative");
  RequireOption(max_features >= 1 && num_landmarks >= 1,
                "recording.max_features and num_landmarks must be positive");
  RequireOption(
      track_sigma_px > 0.0 && match_sigma_px > 0.0 && map_sigma_m >= 0.0,
      "recording.track_sigma_px and match_sigma_px must be positive, map_sigma_m not negative");
  RequireOption(track_loss >= 0.0 && track_loss <= 1.0, "recording.track_loss must be in [0, 1]");
  RequireOption(
      min_distance_m > 0.0 && max_distance_m >= min_distance_m && max_height_m >= min_height_m,
      "recording: distances and heights must be in order");
  RequireOption(max_matches >= 0, "recording.max_matches must not be negative");
  RequireOption(wrong_match_fraction >= 0.0 && wrong_match_fraction <= 1.0,
                "recording.wrong_match_fraction must be in [0, 1]");
  RequireOption(start_tilt_sigma_rad > 0.0 && start_velocity_sigma_m_s > 0.0 &&
                    start_gyro_bias_sigma_rad_s > 0.0 && start_accel_bias_sigma_m_s2 > 0.0,
                "recording: standard deviations of the start must be positive");
}

StartState DrawStart(const ImuState& truth, const RecordingOptions& options,
                     std::mt19937_64* random) {
  const Eigen::Matrix3d rotation = truth.local_from_imu.rotation.toRotationMatrix();
  const Eigen::Quaterniond turn = ExpSo3({0.0, 0.0, -std::atan2(rotation(1, 0), rotation(0, 0))});
  const auto square = [](double sigma) { return Eigen::Vector3d::Constant(sigma * sigma); };
  StartState start;
  Eigen::Matrix<double, kImuDim, 1> variance = Eigen::Matrix<double, kImuDim, 1>::Zero();
  variance.head<2>() = square(options.start_tilt_sigma_rad).head<2>();
  variance.segment<3>(kVelocityIdx) = square(options.start_velocity_sigma_m_s);
  variance.segment<3>(kGyroBiasIdx) = square(options.start_gyro_bias_sigma_rad_s);
  variance.segment<3>(kAccelBiasIdx) = square(options.start_accel_bias_sigma_m_s2);
  start.covariance = variance.asDiagonal();
  Eigen::Vector3d tilt = DrawGaussian(options.start_tilt_sigma_rad, random);
  tilt.z() = 0.0;
  start.imu.local_from_imu =
      Rigid3d(ExpSo3(tilt) * turn * truth.local_from_imu.rotation, Eigen::Vector3d::Zero());
  start.imu.velocity_in_local =
      turn * truth.velocity_in_local + DrawGaussian(options.start_velocity_sigma_m_s, random);
  start.imu.gyro_bias = truth.gyro_bias + DrawGaussian(options.start_gyro_bias_sigma_rad_s, random);
  start.imu.accel_bias =
      truth.accel_bias + DrawGaussian(options.start_accel_bias_sigma_m_s2, random);
  return start;
}

Recording SimulateRecording(const Trajectory& trajectory, const RecordingOptions& options) {
  options.Validate();
  return Simulator(trajectory, options).Run();
}

}  // namespace cairn::fusion
