#include "lab/city/phone_sequence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "core/angles.h"
#include "core/geodesy.h"
#include "core/require.h"
#include "eval/recordings/measure_motion.h"
#include "eval/recordings/motion.h"
#include "lab/city/camera_angles.h"
#include "lab/city/city_region.h"
#include "lab/city/hashed_random.h"

namespace cairn {
namespace {

constexpr double kStreetEndM = 4.0;   // Distance to the crossing at which the walk turns.
constexpr double kStepHz = 1.9;       // Footsteps.
constexpr double kBounceM = 0.02;     // Vertical motion of the phone at each step.
constexpr double kSidestepM = 0.015;  // Sideways motion, at half the frequency.

// Streams of random numbers that must stay separate.
enum SequenceStream : uint64_t {
  kWalkStream = 0x601,
  kSequenceBiasStream,
  kSampleStream,
  kFrameStream,
  kSequenceTrackStream,
};

Eigen::Vector3d DrawVector(HashedRandom* random) {
  const double x = random->Normal(), y = random->Normal(), z = random->Normal();
  return {x, y, z};
}

// The phone's IMU has x to the right, y up, and z out of the screen, opposite to the camera's view.
Rigid3d CamFromImu() {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX())),
          Eigen::Vector3d(0.012, 0.058, 0.004)};
}

// The walk as a smooth function of time.
class Walk {
 public:
  Walk(const City& city, const PhoneSequenceOptions& options) : city_(city), options_(options) {
    HashedRandom random(HashOf(options.seed, kWalkStream));
    const std::vector<CityStreet> streets =
        city.StreetsIn(BoxAroundPoint(Eigen::Vector2d::Zero(), 1.0));
    street_ = streets[static_cast<size_t>(random.Index(static_cast<int>(streets.size())))];
    side_ = random.Chance(0.5) ? 1 : -1;
    reach_m_ = std::max(1.0, 0.5 * street_.LengthM() - kStreetEndM);
    radians_per_s_ = options.speed_m_per_s / reach_m_;
    start_rad_ = random.Uniform(0.0, 2.0 * kPi);
    for (double& phase_rad : phases_rad_) {
      phase_rad = random.Uniform(0.0, 2.0 * kPi);
    }
    local_from_site_ = Rigid3d();
    const Eigen::Vector3d start_in_ecef = city.ecef_from_site() * ImuInSite(0.0).translation;
    ecef_from_local_ = EcefFromEnu(GeodeticFromEcef(start_in_ecef));
    local_from_site_ = ecef_from_local_.Inverse() * city.ecef_from_site();
  }

  const CityStreet& street() const { return street_; }
  const Rigid3d& ecef_from_local() const { return ecef_from_local_; }
  const Rigid3d& local_from_site() const { return local_from_site_; }

  Rigid3d LocalFromImu(double t_s) const { return local_from_site_ * ImuInSite(t_s); }

 private:
  Rigid3d ImuInSite(double t_s) const {
    const double along_m =
        0.5 * street_.LengthM() + reach_m_ * std::sin(radians_per_s_ * t_s + start_rad_);
    const double step_rad = 2.0 * kPi * kStepHz * t_s;
    const double left_m =
        side_ * (0.5 * street_.width_m - 0.6 * std::max(1.0, street_.sidewalk_m)) +
        kSidestepM * std::sin(0.5 * step_rad + phases_rad_[0]);
    const Eigen::Vector2d at = street_.At(along_m, left_m);
    const double z_m = city_.GroundM(at) + options_.height_m + kBounceM * std::sin(step_rad);
    const Eigen::Vector2d direction = street_.Direction();
    CameraAngles angles;
    angles.yaw_rad = std::atan2(direction.y(), direction.x()) - side_ * 0.5 * kPi +
                     0.8 * std::sin(0.31 * t_s + phases_rad_[1]) +
                     0.05 * std::sin(1.7 * t_s + phases_rad_[2]);
    angles.pitch_rad = 0.1 + 0.12 * std::sin(0.47 * t_s + phases_rad_[3]) +
                       0.01 * std::sin(step_rad + phases_rad_[4]);
    angles.roll_rad = 0.06 * std::sin(0.6 * t_s + phases_rad_[5]);
    const Rigid3d cam_from_site = CamFromEnu({at.x(), at.y(), z_m}, angles);
    return cam_from_site.Inverse() * CamFromImu();
  }

  const City& city_;
  const PhoneSequenceOptions& options_;
  CityStreet street_;
  int side_ = 1;
  double reach_m_ = 0.0;
  double radians_per_s_ = 0.0;
  double start_rad_ = 0.0;
  std::array<double, 6> phases_rad_{};
  Rigid3d ecef_from_local_;
  Rigid3d local_from_site_;
};

void FillImu(const Walk& walk, const PhoneSequenceOptions& options, PhoneSequence* sequence) {
  HashedRandom bias(HashOf(options.seed, kSequenceBiasStream));
  fusion::InertialUnit unit{.rate_hz = options.imu_rate_hz, .noise = options.imu_noise};
  unit.gyro_bias = options.gyro_bias_sigma_rad_s * DrawVector(&bias);
  unit.accel_bias = options.accel_bias_sigma_m_s2 * DrawVector(&bias);
  unit.gravity_m_s2 = kGravityMS2;
  // Each sample has its own stream.
  HashedRandom random(0);
  int64_t sample_of_random = -1;
  const auto normal_vectors = [&](int64_t sample) {
    if (std::exchange(sample_of_random, sample) != sample) {
      random = HashedRandom(HashOf(options.seed, kSampleStream, sample));
    }
    return DrawVector(&random);
  };
  const auto num_samples = static_cast<int>(options.duration_s * options.imu_rate_hz) + 1;
  fusion::InertialWalk measured = fusion::MeasureMotion(
      fusion::MotionAlong([&walk](double t_s) { return walk.LocalFromImu(t_s); }), num_samples,
      unit, normal_vectors);
  sequence->imu = std::move(measured.imu);
  sequence->truth = std::move(measured.truth);
}

// Tracks landmarks from frame to frame.
class Tracker {
 public:
  Tracker(const PhoneSequenceOptions& options, const CityRegion& region)
      : options_(options), region_(region), detector_(options.detector) {
    detector_.position_noise = 0.0;  // Trackers have a noise of their own.
  }

  std::vector<fusion::TrackedFeature> Track(const Rigid3d& cam_from_site, uint64_t frame_id) {
    const std::vector<Detection> detections = DetectLandmarks(
        region_, options_.camera, cam_from_site, detector_, frame_id, HashOf(options_.seed));
    std::map<uint64_t, uint64_t> followed;
    std::vector<fusion::TrackedFeature> features;
    const auto add = [&](const Detection& detection, uint64_t track_id) {
      HashedRandom random(HashOf(frame_id, kSequenceTrackStream, detection.look.landmark));
      const double x_px = detection.keypoint.x_px + options_.pixel_sigma * random.Normal();
      const double y_px = detection.keypoint.y_px + options_.pixel_sigma * random.Normal();
      if (!random.Chance(options_.lost_share)) {
        features.push_back({track_id, {x_px, y_px}});
        followed[detection.look.landmark] = track_id;
      }
    };
    for (const Detection& detection : detections) {
      if (const auto track = tracks_.find(detection.look.landmark); track != tracks_.end()) {
        add(detection, track->second);
      }
    }
    for (const Detection& detection : detections) {
      if (static_cast<int>(features.size()) >= options_.num_tracks) {
        break;
      }
      if (!tracks_.contains(detection.look.landmark)) {
        add(detection, next_track_id_++);
      }
    }
    tracks_ = std::move(followed);
    std::sort(features.begin(), features.end(),
              [](const auto& a, const auto& b) { return a.track_id < b.track_id; });
    return features;
  }

 private:
  const PhoneSequenceOptions& options_;
  const CityRegion& region_;
  DetectorOptions detector_;
  std::map<uint64_t, uint64_t> tracks_;  // By landmark, at the last frame.
  uint64_t next_track_id_ = 0;
};

void FillFrames(const City& city, const Walk& walk, const PhoneSequenceOptions& options,
                PhoneSequence* sequence) {
  const auto stride =
      static_cast<size_t>(std::max(1.0, std::round(options.imu_rate_hz / options.frame_rate_hz)));
  const Rigid3d site_from_local = walk.local_from_site().Inverse();
  CityBox reach;
  for (size_t k = 0; k < sequence->truth.size(); k += stride) {
    const Eigen::Vector3d at = site_from_local * sequence->truth[k].local_from_imu.translation;
    reach.extend(BoxAroundPoint(at.head<2>(), options.detector.max_range_m));
  }
  const CityRegion region(city, reach, options.time_years);
  Tracker tracker(options, region);
  for (size_t k = 0; k < sequence->truth.size(); k += stride) {
    SequenceFrame frame;
    frame.timestamp_ns = sequence->imu[k].timestamp_ns;
    frame.cam_from_local = sequence->cam_from_imu * sequence->truth[k].local_from_imu.Inverse();
    frame.features = tracker.Track(frame.cam_from_local * walk.local_from_site(),
                                   HashOf(options.seed, kFrameStream, k));
    sequence->frames.push_back(std::move(frame));
  }
}

}  // namespace

void PhoneSequenceOptions::Validate() const {
  RequireWithin("sequence.duration_s", duration_s, 0.1, 3600.0);
  RequireWithin("sequence.imu_rate_hz", imu_rate_hz, 10.0, 2000.0);
  RequireWithin("sequence.frame_rate_hz", frame_rate_hz, 0.1, std::min(120.0, imu_rate_hz));
  RequireWithin("sequence.speed_m_per_s", speed_m_per_s, 0.0, 10.0);
  RequireWithin("sequence.height_m", height_m, 0.2, 4.0);
  RequireWithin("sequence.num_tracks", num_tracks, 1, 5000);
  RequireWithin("sequence.pixel_sigma", pixel_sigma, 0.0, 20.0);
  RequireWithin("sequence.lost_share", lost_share, 0.0, 1.0);
  RequireWithin("sequence.time_years", time_years, 0.0, 200.0);
  detector.Validate();
  RequireWithin("sequence.imu_noise.gyro_density", imu_noise.gyro_density, 0.0, 1.0);
  RequireWithin("sequence.imu_noise.accel_density", imu_noise.accel_density, 0.0, 10.0);
  RequireWithin("sequence.imu_noise.gyro_walk", imu_noise.gyro_walk, 0.0, 1.0);
  RequireWithin("sequence.imu_noise.accel_walk", imu_noise.accel_walk, 0.0, 10.0);
  RequireWithin("sequence.gyro_bias_sigma_rad_s", gyro_bias_sigma_rad_s, 0.0, 1.0);
  RequireWithin("sequence.accel_bias_sigma_m_s2", accel_bias_sigma_m_s2, 0.0, 10.0);
}

PhoneSequence SimulatePhoneSequence(const City& city, const PhoneSequenceOptions& options) {
  options.Validate();
  const Walk walk(city, options);
  PhoneSequence sequence;
  sequence.street = walk.street();
  sequence.camera = options.camera;
  sequence.cam_from_imu = CamFromImu();
  sequence.ecef_from_local = walk.ecef_from_local();
  FillImu(walk, options, &sequence);
  FillFrames(city, walk, options, &sequence);
  return sequence;
}

}  // namespace cairn
