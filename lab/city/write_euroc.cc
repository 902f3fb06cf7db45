#include <fmt/format.h>

#include <filesystem>
#include <string>
#include <system_error>

#include "core/file_bytes.h"
#include "lab/city/phone_sequence.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

void WriteFile(const fs::path& path, const std::string& text) {
  std::error_code ignored;
  fs::create_directories(path.parent_path(), ignored);
  WriteTextFile(path.string(), text);
}

std::string Row(const Eigen::Vector3d& v) {
  return fmt::format("{:.12g},{:.12g},{:.12g}", v.x(), v.y(), v.z());
}

std::string ImuCsv(const PhoneSequence& sequence) {
  std::string text =
      "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
      "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n";
  for (const fusion::ImuSample& sample : sequence.imu) {
    text += fmt::format("{},{},{}\n", sample.timestamp_ns, Row(sample.gyro_rad_s),
                        Row(sample.accel_m_s2));
  }
  return text;
}

std::string TruthCsv(const PhoneSequence& sequence) {
  std::string text =
      "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], "
      "q_RS_z [], v_RS_R_x [m s^-1], v_RS_R_y [m s^-1], v_RS_R_z [m s^-1], "
      "b_w_RS_S_x [rad s^-1], b_w_RS_S_y [rad s^-1], b_w_RS_S_z [rad s^-1], "
      "b_a_RS_S_x [m s^-2], b_a_RS_S_y [m s^-2], b_a_RS_S_z [m s^-2]\n";
  for (size_t i = 0; i < sequence.truth.size(); ++i) {
    const fusion::ImuState& state = sequence.truth[i];
    const Eigen::Quaterniond& q = state.local_from_imu.rotation;
    text += fmt::format("{},{},{:.12g},{:.12g},{:.12g},{:.12g},{},{},{}\n",
                        sequence.imu[i].timestamp_ns, Row(state.local_from_imu.translation), q.w(),
                        q.x(), q.y(), q.z(), Row(state.velocity_in_local), Row(state.gyro_bias),
                        Row(state.accel_bias));
  }
  return text;
}

std::string FramesCsv(const PhoneSequence& sequence) {
  std::string text = "#timestamp [ns],filename\n";
  for (const SequenceFrame& frame : sequence.frames) {
    text += fmt::format("{0},{0}.png\n", frame.timestamp_ns);
  }
  return text;
}

std::string TracksCsv(const PhoneSequence& sequence) {
  std::string text = "#timestamp [ns],track,x [px],y [px]\n";
  for (const SequenceFrame& frame : sequence.frames) {
    for (const fusion::TrackedFeature& feature : frame.features) {
      text += fmt::format("{},{},{:.4f},{:.4f}\n", frame.timestamp_ns, feature.track_id,
                          feature.pixel.x(), feature.pixel.y());
    }
  }
  return text;
}

std::string TransformYaml(const Rigid3d& target_from_source) {
  const Eigen::Matrix<double, 3, 4> m = target_from_source.ToMatrix();
  std::string text = "  cols: 4\n  rows: 4\n  data: [";
  for (int row = 0; row < 3; ++row) {
    text += fmt::format("{:.12g}, {:.12g}, {:.12g}, {:.12g},\n         ", m(row, 0), m(row, 1),
                        m(row, 2), m(row, 3));
  }
  return text + "0.0, 0.0, 0.0, 1.0]\n";
}

std::string ImuYaml(const PhoneSequence& sequence, const fusion::ImuNoise& noise) {
  const double step_s =
      1e-9 * static_cast<double>(sequence.imu[1].timestamp_ns - sequence.imu[0].timestamp_ns);
  return "sensor_type: imu\ncomment: simulated phone\nT_BS:\n" + TransformYaml(Rigid3d()) +
         fmt::format(
             "rate_hz: {:g}\ngyroscope_noise_density: {:g}\ngyroscope_random_walk: {:g}\n"
             "accelerometer_noise_density: {:g}\naccelerometer_random_walk: {:g}\n",
             1.0 / step_s, noise.gyro_density, noise.gyro_walk, noise.accel_density,
             noise.accel_walk);
}

std::string CameraYaml(const PhoneSequence& sequence) {
  const Camera& camera = sequence.camera;
  return "sensor_type: camera\ncomment: simulated phone\n# imu_from_cam\nT_BS:\n" +
         TransformYaml(sequence.cam_from_imu.Inverse()) +
         fmt::format(
             "resolution: [{}, {}]\ncamera_model: pinhole\n# fu, fv, cu, cv; the center of the "
             "upper left pixel is (0.5, 0.5)\nintrinsics: [{}, {}, {}, {}]\n"
             "distortion_model: radial-tangential\ndistortion_coefficients: [0.0, 0.0, 0.0, 0.0]\n",
             camera.width_px(), camera.height_px(), camera.params()[0], camera.params()[1],
             camera.params()[2], camera.params()[3]);
}

std::string OriginCsv(const PhoneSequence& sequence) {
  const Geodetic origin = GeodeticFromEcef(sequence.ecef_from_local.translation);
  return fmt::format("lat_deg,lon_deg,h_m\n{:.12g},{:.12g},{:.6f}\n", origin.lat_deg(),
                     origin.lon_deg(), origin.h_m);
}

}  // namespace

void WriteEurocSequence(const PhoneSequence& sequence, const fusion::ImuNoise& noise,
                        const std::string& dir) {
  const fs::path root = fs::path(dir) / "mav0";
  WriteFile(root / "imu0" / "data.csv", ImuCsv(sequence));
  WriteFile(root / "imu0" / "sensor.yaml", ImuYaml(sequence, noise));
  WriteFile(root / "cam0" / "data.csv", FramesCsv(sequence));
  WriteFile(root / "cam0" / "sensor.yaml", CameraYaml(sequence));
  WriteFile(root / "cam0" / "tracks.csv", TracksCsv(sequence));
  WriteFile(root / "state_groundtruth_estimate0" / "data.csv", TruthCsv(sequence));
  WriteFile(root / "origin.csv", OriginCsv(sequence));
}

}  // namespace cairn
