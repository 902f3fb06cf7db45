#include "lab/city/cameras/phone_sequence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "core/angles.h"
#include "core/geodesy.h"
#include "core/require.h"
#include "lab/city/cameras/camera_angles.h"
#include "lab/city/geometry/city_region.h"
#include "lab/city/geometry/hashed_random.h"

namespace cairn {
namespace {

constexpr double kStreetEndM = 4.0;   // Distance to the crossing at which the walk turns.
constexpr double kStepHz = 1.9;       // Footsteps.
constexpr double kBounceM = 0.02;     // Vertical motion of the phone at each step.
constexpr double kSidestepM = 0.015;  // Sideways motion, at half the frequency.
constexpr double kDifferenceS = 1e-3;

// Streams of random numbers that must stay separate.
enum Stream : uint64_t {
  kWalkStream = 0x601,
  kBiasStream,
  kSampleStream,
  kFrameStream,
  kTrackStream,
};

Eigen::Vector3d DrawVector(double sigma, HashedRandom* random) {
  const double x = random->Normal(), y = random->Normal(), z = random->Normal();
  return sigma * Eigen::Vector3d(x, y, z);
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

  // Differences of fourth order give the derivatives with a relative error below 1e-6.
  Eigen::Vector3d Velocity(double t_s) const {
    const auto at = [&](int steps) { return PositionAt(t_s + steps * kDifferenceS); };
    return (8.0 * (at(1) - at(-1)) - (at(2) - at(-2))) / (12.0 * kDifferenceS);
  }
  Eigen::Vector3d Acceleration(double t_s) const {
    const auto at = [&](int steps) { return PositionAt(t_s + steps * kDifferenceS); };
    return (16.0 * (at(1) + at(-1)) - (at(2) + at(-2)) - 30.0 * at(0)) /
           (12.0 * kDifferenceS * kDifferenceS);
  }
  Eigen::Vector3d AngularVelocityInImu(double t_s) const {
    const auto turn = [&](int steps) {
      const Eigen::Quaterniond before = LocalFromImu(t_s - steps * kDifferenceS).rotation;
      const Eigen::Quaterniond after = LocalFromImu(t_s + steps * kDifferenceS).rotation;
      return LogSo3(before.conjugate() * after);
    };
    // The turns are taken about the middle. Expressed in the IMU's frame at t, they differ by terms
    // of third order.
    return (8.0 * turn(1) - turn(2)) / (12.0 * kDifferenceS);
  }

 private:
  Eigen::Vector3d PositionAt(double t_s) const { return LocalFromImu(t_s).translation; }

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
  const double step_s = 1.0 / options.imu_rate_hz;
  const double root_rate = std::sqrt(options.imu_rate_hz), root_step = std::sqrt(step_s);
  const ImuNoise& noise = options.imu;
  HashedRandom bias(HashOf(options.seed, kBiasStream));
  Eigen::Vector3d gyroscope_bias = DrawVector(noise.gyroscope_bias_sigma, &bias);
  Eigen::Vector3d accelerometer_bias = DrawVector(noise.accelerometer_bias_sigma, &bias);
  const auto count = static_cast<int64_t>(options.duration_s * options.imu_rate_hz) + 1;
  const Eigen::Vector3d gravity_in_local(0.0, 0.0, -kGravityMS2);
  for (int64_t k = 0; k < count; ++k) {
    const double t_s = static_cast<double>(k) * step_s;
    HashedRandom random(HashOf(options.seed, kSampleStream, k));
    TrueState state;
    state.timestamp_ns = std::llround(1e9 * t_s);
    state.local_from_imu = walk.LocalFromImu(t_s);
    state.velocity_in_local = walk.Velocity(t_s);
    state.gyroscope_bias = gyroscope_bias;
    state.accelerometer_bias = accelerometer_bias;
    ImuSample sample;
    sample.timestamp_ns = state.timestamp_ns;
    sample.angular_velocity_rad_s = walk.AngularVelocityInImu(t_s) + gyroscope_bias +
                                    DrawVector(noise.gyroscope_density * root_rate, &random);
    sample.specific_force_m_s2 =
        state.local_from_imu.rotation.conjugate() * (walk.Acceleration(t_s) - gravity_in_local) +
        accelerometer_bias + DrawVector(noise.accelerometer_density * root_rate, &random);
    gyroscope_bias += DrawVector(noise.gyroscope_walk * root_step, &random);
    accelerometer_bias += DrawVector(noise.accelerometer_walk * root_step, &random);
    sequence->truth.push_back(state);
    sequence->imu.push_back(sample);
  }
}

// Tracks landmarks from frame to frame.
class Tracker {
 public:
  Tracker(const PhoneSequenceOptions& options, const CityRegion& region)
      : options_(options), region_(region), detector_(options.detector) {
    detector_.position_noise = 0.0;  // Trackers have a noise of their own.
  }

  std::vector<TrackedFeature> Track(const Rigid3d& cam_from_site, uint64_t frame_id) {
    const std::vector<Sighting> sightings = DetectLandmarks(
        region_, options_.camera, cam_from_site, detector_, frame_id, HashOf(options_.seed));
    std::map<uint64_t, int64_t> followed;
    std::vector<TrackedFeature> features;
    const auto add = [&](const Sighting& sighting, int64_t track_id) {
      HashedRandom random(HashOf(frame_id, kTrackStream, sighting.look.landmark));
      const double x_px = sighting.keypoint.x_px + options_.pixel_sigma * random.Normal();
      const double y_px = sighting.keypoint.y_px + options_.pixel_sigma * random.Normal();
      if (!random.Chance(options_.lost_share)) {
        features.push_back({track_id, {x_px, y_px}});
        followed[sighting.look.landmark] = track_id;
      }
    };
    for (const Sighting& sighting : sightings) {
      if (const auto track = tracks_.find(sighting.look.landmark); track != tracks_.end()) {
        add(sighting, track->second);
      }
    }
    for (const Sighting& sighting : sightings) {
      if (static_cast<int>(features.size()) >= options_.num_tracks) {
        break;
      }
      if (!tracks_.contains(sighting.look.landmark)) {
        add(sighting, next_track_id_++);
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
  std::map<uint64_t, int64_t> tracks_;  // By landmark, at the last frame.
  int64_t next_track_id_ = 0;
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
    frame.timestamp_ns = sequence->truth[k].timestamp_ns;
    frame.cam_from_local = sequence->cam_from_imu * sequence->truth[k].local_from_imu.Inverse();
    frame.features = tracker.Track(frame.cam_from_local * walk.local_from_site(),
                                   HashOf(options.seed, kFrameStream, k));
    sequence->frames.push_back(std::move(frame));
  }
}

}  // namespace

void ImuNoise::Validate() const {
  RequireWithin("sequence.imu.gyroscope_density", gyroscope_density, 0.0, 1.0);
  RequireWithin("sequence.imu.accelerometer_density", accelerometer_density, 0.0, 10.0);
  RequireWithin("sequence.imu.gyroscope_walk", gyroscope_walk, 0.0, 1.0);
  RequireWithin("sequence.imu.accelerometer_walk", accelerometer_walk, 0.0, 10.0);
  RequireWithin("sequence.imu.gyroscope_bias_sigma", gyroscope_bias_sigma, 0.0, 1.0);
  RequireWithin("sequence.imu.accelerometer_bias_sigma", accelerometer_bias_sigma, 0.0, 10.0);
}

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
  imu.Validate();
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
