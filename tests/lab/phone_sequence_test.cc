#include "lab/city/phone_sequence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "core/error.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

City SmallTown() {
  CityOptions options = CityPreset(CityCharacter::kOldTown);
  options.min_landmark_size_m = 0.03;
  return City(options);
}

PhoneSequenceOptions Noiseless() {
  PhoneSequenceOptions options;
  options.duration_s = 10.0;
  options.frame_rate_hz = 5.0;
  options.imu_noise = {
      .gyro_density = 0.0, .accel_density = 0.0, .gyro_walk = 0.0, .accel_walk = 0.0};
  options.gyro_bias_sigma_rad_s = 0.0;
  options.accel_bias_sigma_m_s2 = 0.0;
  return options;
}

TEST(PhoneSequence, IntegratedSamplesGiveThePoses) {
  const PhoneSequence sequence = SimulatePhoneSequence(SmallTown(), Noiseless());
  ASSERT_EQ(sequence.imu.size(), 2001u);
  const Eigen::Vector3d gravity_in_local(0.0, 0.0, -kGravityMS2);
  Eigen::Quaterniond rotation = sequence.truth[0].local_from_imu.rotation;
  Eigen::Vector3d position = sequence.truth[0].local_from_imu.translation;
  Eigen::Vector3d velocity = sequence.truth[0].velocity_in_local;
  for (size_t k = 0; k + 1 < sequence.imu.size(); ++k) {  // Trapezoidal rule.
    const fusion::ImuSample &a = sequence.imu[k], &b = sequence.imu[k + 1];
    const double dt_s = 1e-9 * static_cast<double>(b.timestamp_ns - a.timestamp_ns);
    const Eigen::Quaterniond next = rotation * ExpSo3(0.5 * dt_s * (a.gyro_rad_s + b.gyro_rad_s));
    const Eigen::Vector3d acceleration =
        0.5 * (rotation * a.accel_m_s2 + next * b.accel_m_s2) + gravity_in_local;
    position += dt_s * velocity + 0.5 * dt_s * dt_s * acceleration;
    velocity += dt_s * acceleration;
    rotation = next.normalized();
  }
  const fusion::ImuState& end = sequence.truth.back();
  EXPECT_GT((end.local_from_imu.translation - sequence.truth[0].local_from_imu.translation).norm(),
            2.0);
  EXPECT_LT(RotationAngleRad(rotation, end.local_from_imu.rotation), 2e-4);
  EXPECT_LT((velocity - end.velocity_in_local).norm(), 5e-3);
  EXPECT_LT((position - end.local_from_imu.translation).norm(), 0.03);
}

TEST(PhoneSequence, NoiseAndBiasAreAsAskedFor) {
  PhoneSequenceOptions options = Noiseless();
  options.duration_s = 30.0;
  const PhoneSequence ideal = SimulatePhoneSequence(SmallTown(), options);
  const PhoneSequenceOptions defaults;
  options.imu_noise = defaults.imu_noise;
  options.gyro_bias_sigma_rad_s = defaults.gyro_bias_sigma_rad_s;
  options.accel_bias_sigma_m_s2 = defaults.accel_bias_sigma_m_s2;
  const PhoneSequence real = SimulatePhoneSequence(SmallTown(), options);
  ASSERT_EQ(ideal.imu.size(), real.imu.size());
  double sum_sq_gyroscope = 0.0, sum_sq_accelerometer = 0.0;
  for (size_t k = 0; k < real.imu.size(); ++k) {
    sum_sq_gyroscope +=
        (real.imu[k].gyro_rad_s - ideal.imu[k].gyro_rad_s - real.truth[k].gyro_bias).squaredNorm();
    sum_sq_accelerometer +=
        (real.imu[k].accel_m_s2 - ideal.imu[k].accel_m_s2 - real.truth[k].accel_bias).squaredNorm();
  }
  const double count = 3.0 * static_cast<double>(real.imu.size());
  EXPECT_NEAR(std::sqrt(sum_sq_gyroscope / count), 1.5e-3 * std::sqrt(200.0), 1e-3);
  EXPECT_NEAR(std::sqrt(sum_sq_accelerometer / count), 1.5e-2 * std::sqrt(200.0), 1e-2);
  const Eigen::Vector3d walked = real.truth.back().accel_bias - real.truth.front().accel_bias;
  EXPECT_GT(walked.norm(), 1e-4);
  EXPECT_LT(walked.norm(), 5.0 * 3e-4 * std::sqrt(30.0 * 3.0));
}

TEST(PhoneSequence, TracksFollowFixedPointsOfTheWorld) {
  PhoneSequenceOptions options = Noiseless();
  options.pixel_sigma = 0.0;
  const PhoneSequence sequence = SimulatePhoneSequence(SmallTown(), options);
  std::map<uint64_t, std::vector<std::pair<size_t, Eigen::Vector2d>>> tracks;
  for (size_t i = 0; i < sequence.frames.size(); ++i) {
    EXPECT_LE(sequence.frames[i].features.size(), 150u);
    for (const fusion::TrackedFeature& feature : sequence.frames[i].features) {
      tracks[feature.track_id].push_back({i, feature.pixel});
    }
  }
  int num_long = 0;
  for (const auto& [track_id, looks] : tracks) {
    for (size_t i = 1; i < looks.size(); ++i) {
      EXPECT_EQ(looks[i].first, looks[i - 1].first + 1);  // Without a gap.
    }
    if (looks.size() < 5) {
      continue;
    }
    ++num_long;
    // Rays from the first and the last look, of lines that pass each other within millimeters.
    const auto ray = [&](const std::pair<size_t, Eigen::Vector2d>& look) {
      const Rigid3d local_from_cam = sequence.frames[look.first].cam_from_local.Inverse();
      return std::pair(local_from_cam.translation,
                       Eigen::Vector3d(local_from_cam.rotation *
                                       sequence.camera.Unproject(look.second).value()));
    };
    const auto [from_a, way_a] = ray(looks.front());
    const auto [from_b, way_b] = ray(looks.back());
    const Eigen::Vector3d across = way_a.cross(way_b);
    if (across.norm() > 0.01) {
      EXPECT_LT(std::abs(across.normalized().dot(from_b - from_a)), 2e-3);
    }
  }
  EXPECT_GT(num_long, 50);
}

TEST(PhoneSequence, StartsAtTheOriginOfALevelFrame) {
  const PhoneSequence sequence = SimulatePhoneSequence(SmallTown(), Noiseless());
  EXPECT_LT(sequence.truth[0].local_from_imu.translation.norm(), 1e-6);
  EXPECT_NEAR(sequence.imu[0].accel_m_s2.norm(), kGravityMS2, 4.0);
  const Geodetic origin = GeodeticFromEcef(sequence.ecef_from_local.translation);
  EXPECT_LT(GroundDistanceM(origin, CityPreset(CityCharacter::kOldTown).center), 150.0);
}

TEST(PhoneSequence, IsTheSameForTheSameSeedOnly) {
  PhoneSequenceOptions options;
  options.duration_s = 1.0;
  const PhoneSequence a = SimulatePhoneSequence(SmallTown(), options);
  const PhoneSequence b = SimulatePhoneSequence(SmallTown(), options);
  options.seed = 9;
  const PhoneSequence c = SimulatePhoneSequence(SmallTown(), options);
  EXPECT_EQ(a.imu.back().accel_m_s2, b.imu.back().accel_m_s2);
  EXPECT_EQ(a.frames.back().features.size(), b.frames.back().features.size());
  EXPECT_NE(a.imu.back().accel_m_s2, c.imu.back().accel_m_s2);
}

TEST(PhoneSequence, RefusesWhatCannotBe) {
  PhoneSequenceOptions options;
  options.frame_rate_hz = 500.0;
  EXPECT_THAT([&] { SimulatePhoneSequence(SmallTown(), options); },
              ::testing::ThrowsMessage<Error>(
                  ::testing::HasSubstr("sequence.frame_rate_hz = 500 must lie in [0.1, 120]")));
  options = {};
  options.imu_noise.gyro_density = -1.0;
  EXPECT_THROW(SimulatePhoneSequence(SmallTown(), options), Error);
}

std::vector<std::vector<double>> ReadCsv(const std::string& path) {
  std::ifstream file(path);
  std::vector<std::vector<double>> rows;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with('#')) {
      continue;
    }
    std::vector<double> row;
    std::stringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) {
      row.push_back(std::strtod(cell.c_str(), nullptr));
    }
    rows.push_back(row);
  }
  return rows;
}

TEST(WriteEurocSequence, FilesHoldTheSequence) {
  PhoneSequenceOptions options;
  options.duration_s = 1.0;
  const PhoneSequence sequence = SimulatePhoneSequence(SmallTown(), options);
  const testing::TempDir dir;
  WriteEurocSequence(sequence, options.imu_noise, dir.path().string());

  const auto imu = ReadCsv(dir.File("mav0/imu0/data.csv"));
  ASSERT_EQ(imu.size(), sequence.imu.size());
  ASSERT_EQ(imu[7].size(), 7u);
  EXPECT_NEAR(imu[7][1], sequence.imu[7].gyro_rad_s.x(), 1e-9);
  EXPECT_NEAR(imu[7][6], sequence.imu[7].accel_m_s2.z(), 1e-9);
  const auto truth = ReadCsv(dir.File("mav0/state_groundtruth_estimate0/data.csv"));
  ASSERT_EQ(truth.size(), sequence.truth.size());
  ASSERT_EQ(truth[3].size(), 17u);
  EXPECT_NEAR(truth[3][4], sequence.truth[3].local_from_imu.rotation.w(), 1e-9);
  EXPECT_NEAR(truth[3][8], sequence.truth[3].velocity_in_local.x(), 1e-9);
  size_t num_features = 0;
  for (const SequenceFrame& frame : sequence.frames) {
    num_features += frame.features.size();
  }
  EXPECT_EQ(ReadCsv(dir.File("mav0/cam0/tracks.csv")).size(), num_features);
  EXPECT_EQ(ReadCsv(dir.File("mav0/cam0/data.csv")).size(), sequence.frames.size());
}

}  // namespace
}  // namespace cairn
