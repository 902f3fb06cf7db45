// Builds a small synthetic street as a reconstruction: landmarks on two facades, and cameras that
// walk between them.
//
// Seen from above, in the enu frame at the origin. The reconstruction's world frame is a scaled and
// turned copy of enu, so that a test notices if code confuses the two:
//
//   y = +width/2   ==================  facade, 10 m high
//                  > > > > > > > > >   cameras, 1.6 m high, from x = start_m to start_m + length_m
//   y = -width/2   ==================  facade
#ifndef CAIRN_TESTS_SUPPORT_RECONSTRUCTION_BUILDER_H_
#define CAIRN_TESTS_SUPPORT_RECONSTRUCTION_BUILDER_H_

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/angles.h"
#include "core/camera.h"
#include "core/features.h"
#include "core/geodesy.h"
#include "core/rigid3.h"
#include "core/scene/reconstruction.h"

namespace cairn::testing {

struct StreetWorldOptions {
  Geodetic origin = Geodetic::FromDegrees(47.3769, 8.5417, 408.0);
  double start_m = 0.0;
  double length_m = 60.0;
  double width_m = 16.0;
  double heading_rad = 0.0;  // Of the views ahead; pi: they look back.
  double keyframe_step_m = 3.0;
  int num_landmarks = 1500;  // Spread over [start_m, start_m + length_m + 20 m].
  int descriptor_dim = 128;
  double pixel_noise_px = 0.3;
  double descriptor_noise = 0.15;  // Relative to the descriptor's length.
  double clutter_ratio = 0.2;      // Keypoints that belong to no landmark.
  double max_view_distance_m = 40.0;
  // Distance in meters after which the facades repeat exactly; 0: they do not repeat.
  double repeat_period_m = 0.0;
  // Share of the landmarks that do not repeat, in a street that repeats.
  double unique_ratio = 0.0;
  Sim3d world_from_enu = {0.2, Eigen::Quaterniond(0.5, 0.5, -0.1, 0.7).normalized(),
                          Eigen::Vector3d(3.0, -2.0, 7.0)};
  uint64_t seed = 1;       // Seed of the landmarks and their looks.
  uint64_t view_seed = 2;  // Seed of the noise in the views: another visit.
};

// A place on a facade and its look.
struct StreetLandmark {
  Eigen::Vector3d x_in_enu;
  Eigen::VectorXf descriptor;        // Without noise.
  double rectified_orientation_rad;  // Relative to the image of gravity.
  double size_m;
};

class StreetWorld {
 public:
  explicit StreetWorld(const StreetWorldOptions& options = {})
      : options_(options), camera_(CameraModel::kPinhole, 640, 480, {400.0, 400.0, 320.0, 240.0}) {
    std::mt19937_64 rng(options.seed);
    MakeLandmarks(&rng);
  }

  const StreetWorldOptions& options() const { return options_; }
  const Camera& camera() const { return camera_; }
  const std::vector<StreetLandmark>& landmarks() const { return landmarks_; }

  // The similarity transform that ingest receives.
  Sim3d EcefFromWorld() const {
    return EcefFromEnu(options_.origin) * options_.world_from_enu.Inverse();
  }

  // Returns a camera at `x_in_enu` that looks along the azimuth (0: along the street; pi/2: at the
  // left facade), turned up by `pitch_rad`.
  static Rigid3d LookAlong(const Eigen::Vector3d& x_in_enu, double azimuth_rad,
                           double pitch_rad = 0.0) {
    Eigen::Matrix3d cam_from_level;  // Rows: right, down, forward for a view along +x.
    cam_from_level << 0, -1, 0, 0, 0, -1, 1, 0, 0;
    const Eigen::Quaterniond level_from_enu(
        Eigen::AngleAxisd(pitch_rad, Eigen::Vector3d::UnitY()) *
        Eigen::AngleAxisd(-azimuth_rad, Eigen::Vector3d::UnitZ()));
    const Eigen::Quaterniond cam_from_enu(Eigen::Quaterniond(cam_from_level) * level_from_enu);
    return {cam_from_enu, -(cam_from_enu * x_in_enu)};
  }

  // One camera every keyframe_step_m. The views alternate: ahead, half left, half right.
  std::vector<Rigid3d> KeyframePoses() const {
    std::vector<Rigid3d> cam_from_enu;
    const int num_keyframes =
        static_cast<int>(std::floor(options_.length_m / options_.keyframe_step_m)) + 1;
    for (int i = 0; i < num_keyframes; ++i) {
      const Eigen::Vector3d x_in_enu(options_.start_m + i * options_.keyframe_step_m,
                                     0.5 * std::sin(0.7 * i), 1.6);
      cam_from_enu.push_back(
          LookAlong(x_in_enu, options_.heading_rad + 0.5 * (i % 3 - 1), 0.05 * std::sin(1.3 * i)));
    }
    return cam_from_enu;
  }

  // Returns the features that a camera sees. `landmark_of_keypoint` (may be null) receives the
  // index of each keypoint's landmark, or -1.
  FeatureSet Photograph(const Rigid3d& cam_from_enu, uint64_t seed,
                        std::vector<int>* landmark_of_keypoint = nullptr) const {
    std::mt19937_64 rng(seed);
    std::vector<Keypoint> keypoints;
    std::vector<Eigen::VectorXf> descriptors;
    std::vector<int> landmark_idx;
    for (size_t i = 0; i < landmarks_.size(); ++i) {
      const Eigen::Vector3d x_in_cam = cam_from_enu * landmarks_[i].x_in_enu;
      const auto pixel = camera_.Project(x_in_cam);
      if (!pixel || x_in_cam.norm() > options_.max_view_distance_m || !camera_.Contains(*pixel)) {
        continue;
      }
      keypoints.push_back(Observe(landmarks_[i], cam_from_enu, *pixel, &rng));
      descriptors.push_back(Perturb(landmarks_[i].descriptor, options_.descriptor_noise, &rng));
      landmark_idx.push_back(static_cast<int>(i));
    }
    const int num_clutter = static_cast<int>(options_.clutter_ratio * keypoints.size());
    for (int i = 0; i < num_clutter; ++i) {
      keypoints.push_back({static_cast<float>(Uniform(&rng) * camera_.width_px()),
                           static_cast<float>(Uniform(&rng) * camera_.height_px()), 2.0f,
                           static_cast<float>(WrapAngleRad(6.28 * Uniform(&rng)))});
      descriptors.push_back(RandomDescriptor(&rng));
      landmark_idx.push_back(-1);
    }
    FeatureSet features;
    features.keypoints = std::move(keypoints);
    features.descriptors.resize(descriptors.size(), options_.descriptor_dim);
    for (size_t i = 0; i < descriptors.size(); ++i) {
      features.descriptors.row(i) = descriptors[i].transpose();
    }
    if (landmark_of_keypoint != nullptr) {
      *landmark_of_keypoint = std::move(landmark_idx);
    }
    return features;
  }

  // Returns the keyframes with their features and true poses, and the landmarks seen at least twice
  // at their true positions. Image names are "0000.jpg", "0001.jpg", ...; gps is the true position.
  Reconstruction Reconstruct() const {
    Reconstruction reconstruction;
    reconstruction.cameras = {camera_};
    std::vector<std::vector<ReconObservation>> tracks(landmarks_.size());
    const Rigid3d ecef_from_enu = EcefFromEnu(options_.origin);
    for (const Rigid3d& cam_from_enu : KeyframePoses()) {
      const int image_idx = static_cast<int>(reconstruction.images.size());
      std::vector<int> landmark_of_keypoint;
      ReconImage image;
      image.name = std::string(4 - std::to_string(image_idx).size(), '0') +
                   std::to_string(image_idx) + ".jpg";
      image.cam_from_world = CamFromTarget(cam_from_enu, options_.world_from_enu);
      image.features = Photograph(cam_from_enu, options_.view_seed * 1'000'003 + image_idx,
                                  &landmark_of_keypoint);
      image.gps = GeodeticFromEcef(ecef_from_enu * cam_from_enu.Inverse().translation);
      for (size_t i = 0; i < landmark_of_keypoint.size(); ++i) {
        if (landmark_of_keypoint[i] >= 0) {
          tracks[landmark_of_keypoint[i]].push_back({image_idx, static_cast<int>(i)});
        }
      }
      reconstruction.images.push_back(std::move(image));
    }
    for (size_t i = 0; i < tracks.size(); ++i) {
      if (tracks[i].size() >= 2) {
        reconstruction.landmarks.push_back(
            {options_.world_from_enu * landmarks_[i].x_in_enu, std::move(tracks[i])});
      }
    }
    return reconstruction;
  }

 private:
  static double Uniform(std::mt19937_64* rng) { return ((*rng)() >> 11) * 0x1.0p-53; }
  static double Normal(std::mt19937_64* rng) {  // Box and Muller; equal on every platform.
    return std::sqrt(-2.0 * std::log(1.0 - Uniform(rng))) * std::cos(2.0 * kPi * Uniform(rng));
  }

  // Non-negative, sparse and integer, with length 512, like SIFT.
  Eigen::VectorXf RandomDescriptor(std::mt19937_64* rng) const {
    Eigen::VectorXf descriptor(options_.descriptor_dim);
    for (float& value : descriptor) {
      value = static_cast<float>(std::pow(std::max(0.0, Normal(rng) + 0.3), 2.0));
    }
    return Rounded(descriptor);
  }
  static Eigen::VectorXf Rounded(const Eigen::VectorXf& descriptor) {
    return (descriptor * (512.0f / std::max(descriptor.norm(), 1e-6f)))
        .array()
        .round()
        .min(255.0f)
        .matrix();
  }
  static Eigen::VectorXf Perturb(const Eigen::VectorXf& descriptor, double noise,
                                 std::mt19937_64* rng) {
    const double sigma = noise * descriptor.norm() / std::sqrt(descriptor.size());
    Eigen::VectorXf noisy = descriptor;
    for (float& value : noisy) {
      value = std::max(0.0f, value + static_cast<float>(sigma * Normal(rng)));
    }
    return Rounded(noisy);
  }

  void MakeLandmarks(std::mt19937_64* rng) {
    const double end_m = options_.start_m + options_.length_m + 20.0;
    const double period_m = options_.repeat_period_m;
    for (int i = 0; static_cast<int>(landmarks_.size()) < options_.num_landmarks; ++i) {
      const bool repeats = period_m > 0.0 && Uniform(rng) >= options_.unique_ratio;
      const double stretch_m = repeats ? period_m : end_m - options_.start_m;
      const double side = i % 2 == 0 ? 0.5 : -0.5;
      StreetLandmark landmark;
      landmark.x_in_enu = {options_.start_m + Uniform(rng) * stretch_m,
                           side * options_.width_m + 0.3 * Normal(rng), 10.0 * Uniform(rng)};
      landmark.descriptor = RandomDescriptor(rng);
      landmark.rectified_orientation_rad = WrapAngleRad(2.0 * kPi * Uniform(rng));
      landmark.size_m = 0.03 * std::exp(0.7 * Normal(rng));
      landmarks_.push_back(landmark);
      while (repeats && landmark.x_in_enu.x() + period_m < end_m) {
        landmark.x_in_enu.x() += period_m;
        landmarks_.push_back(landmark);
      }
    }
  }

  Keypoint Observe(const StreetLandmark& landmark, const Rigid3d& cam_from_enu,
                   const Eigen::Vector2d& pixel, std::mt19937_64* rng) const {
    const double distance_m = (cam_from_enu * landmark.x_in_enu).norm();
    Keypoint keypoint;
    keypoint.x_px = static_cast<float>(pixel.x() + options_.pixel_noise_px * Normal(rng));
    keypoint.y_px = static_cast<float>(pixel.y() + options_.pixel_noise_px * Normal(rng));
    keypoint.scale_px = static_cast<float>(landmark.size_m * camera_.focal_px() / distance_m);
    // The rectified orientation of a keypoint with orientation 0 is minus the orientation of
    // gravity.
    const auto minus_down_rad = GravityRectifiedOrientationRad(
        camera_, keypoint, cam_from_enu.rotation * Eigen::Vector3d(0.0, 0.0, -1.0));
    keypoint.orientation_rad = static_cast<float>(
        WrapAngleRad(landmark.rectified_orientation_rad - minus_down_rad.value_or(0.0)));
    return keypoint;
  }

  StreetWorldOptions options_;
  Camera camera_;
  std::vector<StreetLandmark> landmarks_;
};

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_SUPPORT_RECONSTRUCTION_BUILDER_H_
