// Simulates a walk with a phone in hand: inertial samples, feature tracks and the truth.
#ifndef CAIRN_LAB_CITY_PHONE_SEQUENCE_H_
#define CAIRN_LAB_CITY_PHONE_SEQUENCE_H_

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/inertial/imu.h"
#include "core/rigid3.h"
#include "fusion/tracks/track_table.h"
#include "lab/city/city.h"
#include "lab/city/detector.h"

namespace cairn {

struct PhoneSequenceOptions {
  double duration_s = 30.0;     // [0.1, 3600]
  double imu_rate_hz = 200.0;   // [10, 2000]
  double frame_rate_hz = 10.0;  // [0.1, 120]; at most the IMU rate.
  double speed_m_per_s = 1.3;   // Highest speed of the walk, [0, 10].
  double height_m = 1.5;        // Height of the phone, [0.2, 4].
  int num_tracks = 150;         // Most features tracked at once, [1, 5000].
  double pixel_sigma = 0.5;     // Noise of a feature per axis, [0, 20].
  double lost_share = 0.02;     // Share of the tracks that end from one frame to the next, [0, 1].
  double time_years = 2.5;      // After the first mapping pass, [0, 200].
  Camera camera = Camera(CameraModel::kPinhole, 720, 960, {760.0, 760.0, 360.0, 480.0});
  DetectorOptions detector = {.max_keypoints = 6000, .response_noise = 0.3};
  // A cheaper phone. Densities of the gyroscope in [0, 1], of the accelerometer in [0, 10].
  fusion::ImuNoise imu_noise = {
      .gyro_density = 1.5e-3, .accel_density = 1.5e-2, .gyro_walk = 2e-5, .accel_walk = 3e-4};
  double gyro_bias_sigma_rad_s = 0.005;  // Initial bias per axis, [0, 1].
  double accel_bias_sigma_m_s2 = 0.05;   // Initial bias per axis, [0, 10].
  uint64_t seed = 1;

  // Throws Error(kInvalidArgument) that names the field.
  void Validate() const;
};

struct SequenceFrame {
  int64_t timestamp_ns = 0;  // Timestamp of an IMU sample.
  // Ordered by track. An id is not reused after the track is lost.
  std::vector<fusion::TrackedFeature> features;
  Rigid3d cam_from_local;  // True pose.
};

// `local` is east-north-up at the start. Gravity is (0, 0, -kGravityMS2) there.
inline constexpr double kGravityMS2 = 9.81;

struct PhoneSequence {
  CityStreet street;  // The street whose sidewalk is walked.
  Camera camera;
  Rigid3d cam_from_imu;
  Rigid3d ecef_from_local;
  std::vector<fusion::ImuSample> imu;
  std::vector<fusion::ImuState> truth;  // Parallel to imu.
  std::vector<SequenceFrame> frames;
};

// Simulates a walk to and fro on the sidewalk of a street near the city's center, which the seed
// selects. The phone sways and looks across the street. Poses, velocities and inertial samples come
// from one smooth function of time. Deterministic. Throws the Error(kInvalidArgument) of Validate.
PhoneSequence SimulatePhoneSequence(const City& city, const PhoneSequenceOptions& options);

// Writes the sequence into the folder `dir`, which must exist, in EuRoC's layout (mav0/imu0,
// mav0/cam0, mav0/state_groundtruth_estimate0). The tracks go to mav0/cam0/tracks.csv; see
// docs/simulated_city.md. Throws Error(kIo).
void WriteEurocSequence(const PhoneSequence& sequence, const fusion::ImuNoise& noise,
                        const std::string& dir);

}  // namespace cairn

#endif  // CAIRN_LAB_CITY_PHONE_SEQUENCE_H_
