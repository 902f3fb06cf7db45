// A synthetic query with ground truth: camera, landmarks, correct and wrong correspondences.
#ifndef CAIRN_TESTS_SUPPORT_POSE_SCENE_H_
#define CAIRN_TESTS_SUPPORT_POSE_SCENE_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "core/angles.h"
#include "core/camera.h"
#include "core/rigid3.h"
#include "engine/query/level_frame.h"
#include "engine/query/query_context.h"

namespace cairn::testing {

struct PoseSceneOptions {
  Camera camera;
  int num_keypoints = 100;
  int num_inliers = 50;          // The first keypoints. Each has one right match.
  int matches_per_keypoint = 1;  // All further matches are wrong.
  double pixel_noise_px = 0.5;   // Standard deviation per axis, like the next two.
  double landmark_noise_m = 0.0;
  double gravity_noise_rad = 0.0;
  bool has_gravity = true;
  double max_tilt_rad = 0.3;  // Pitch and roll of the camera, each.
  double min_depth_m = 4.0;
  double max_depth_m = 60.0;
  // Other cameras of a rig. The keypoints are dealt to all cameras in turn.
  std::vector<QueryRigCamera> other_cameras;
  // Radius of the disk that contains the camera. Wrong landmarks reach 50 m further.
  double region_radius_m = 50.0;
  // Wrong matches have the azimuths and sizes of a random place and view.
  double azimuth_noise_rad = 0.4;  // Right matches: mapping camera against query camera.
  double log_size_noise = 0.2;     // Right matches: size of the keypoint.
  uint64_t seed = 1;
};

struct PoseScene {
  Rigid3d cam_from_anchor;
  QueryContext query;
  std::vector<Correspondence> correspondences;  // Ordered by keypoint.
  std::vector<bool> is_correct;                 // Per correspondence.

  Eigen::Vector3d center_in_anchor() const { return cam_from_anchor.Inverse().translation; }

  std::vector<int> AllIndices() const {
    std::vector<int> indices(correspondences.size());
    for (size_t i = 0; i < indices.size(); ++i) {
      indices[i] = static_cast<int>(i);
    }
    return indices;
  }
};

// Draws the parts of a scene.
class PoseSceneBuilder {
 public:
  explicit PoseSceneBuilder(const PoseSceneOptions& options)
      : options_(options), engine_(options.seed) {}

  PoseScene Build() {
    MakeCamera();
    for (int i = 0; i < options_.num_keypoints; ++i) {
      const int correct_rank = i < options_.num_inliers
                                   ? static_cast<int>(Uniform(0, options_.matches_per_keypoint))
                                   : -1;
      AddKeypoint(i, correct_rank);
    }
    return std::move(scene_);
  }

 private:
  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  double Normal(double sigma) {
    return std::normal_distribution<double>(0.0, 1.0)(engine_) * sigma;
  }
  Eigen::Vector3d Normal3(double sigma) { return {Normal(sigma), Normal(sigma), Normal(sigma)}; }

  Eigen::Vector3d InRegion(double margin_m, double min_z_m, double max_z_m) {
    const double radius = (options_.region_radius_m + margin_m) * std::sqrt(Uniform(0, 1));
    const double angle = Uniform(-kPi, kPi);
    return {radius * std::cos(angle), radius * std::sin(angle), Uniform(min_z_m, max_z_m)};
  }

  void MakeCamera() {
    QueryContext& query = scene_.query;
    query.camera = options_.camera;
    query.other_cameras = options_.other_cameras;
    query.region.has_prior = true;
    query.region.radius_m = options_.region_radius_m;
    query.region.prior_sigma_m = options_.region_radius_m / 3.0;
    query.region.min_z_m = -8.0;
    query.region.max_z_m = 12.0;
    // Looking east: x (right) points south, y down, z (forward) east.
    Eigen::Matrix3d anchor_from_level_cam;
    anchor_from_level_cam << 0, 0, 1, -1, 0, 0, 0, -1, 0;
    const Eigen::Quaterniond anchor_from_cam =
        Eigen::AngleAxisd(Uniform(-kPi, kPi), Eigen::Vector3d::UnitZ()) *
        Eigen::Quaterniond(anchor_from_level_cam) *
        Eigen::AngleAxisd(Uniform(-1, 1) * options_.max_tilt_rad, Eigen::Vector3d::UnitX()) *
        Eigen::AngleAxisd(Uniform(-1, 1) * options_.max_tilt_rad, Eigen::Vector3d::UnitZ());
    const Eigen::Vector3d center = InRegion(0.0, 0.0, 4.0);
    scene_.cam_from_anchor = Rigid3d(anchor_from_cam, center).Inverse();
    if (options_.has_gravity) {
      const Eigen::Vector3d down_in_cam =
          ExpSo3(Normal3(options_.gravity_noise_rad)) *
          (scene_.cam_from_anchor.rotation * -Eigen::Vector3d::UnitZ());
      query.down_in_cam = down_in_cam.normalized();
      query.level_from_cam = LevelFromCam(down_in_cam);
    }
  }

  void AddKeypoint(int keypoint_idx, int correct_rank) {
    const int camera_idx = keypoint_idx % scene_.query.num_cameras();
    const Camera& camera =
        camera_idx == 0 ? options_.camera : options_.other_cameras[camera_idx - 1].camera;
    const Rigid3d first_from_own =
        camera_idx == 0 ? Rigid3d()
                        : options_.other_cameras[camera_idx - 1].cam_from_first.Inverse();
    std::optional<Eigen::Vector3d> ray;
    Eigen::Vector2d pixel;
    do {
      pixel = {Uniform(0, camera.width_px()), Uniform(0, camera.height_px())};
      ray = camera.Unproject(pixel);
    } while (!ray);
    const double distance_m = Uniform(options_.min_depth_m, options_.max_depth_m);
    const Eigen::Vector3d seen_in_anchor =
        scene_.cam_from_anchor.Inverse() * (first_from_own * (*ray * distance_m));
    const Eigen::Vector2d noisy =
        pixel + Eigen::Vector2d(Normal(options_.pixel_noise_px), Normal(options_.pixel_noise_px));
    const Eigen::Vector3d noisy_ray =
        first_from_own.rotation * camera.Unproject(noisy).value_or(Eigen::Vector3d::Zero());
    if (scene_.query.is_rig()) {
      scene_.query.camera_of_keypoint.push_back(static_cast<uint8_t>(camera_idx));
      scene_.query.origins_in_cam.push_back(first_from_own.translation);
    }

    Keypoint keypoint;
    keypoint.x_px = static_cast<float>(noisy.x());
    keypoint.y_px = static_cast<float>(noisy.y());
    keypoint.scale_px = static_cast<float>(std::exp(Uniform(std::log(1.5), std::log(15.0))));
    scene_.query.keypoints.push_back(keypoint);
    scene_.query.rays_in_cam.push_back(noisy_ray);
    for (int rank = 0; rank < options_.matches_per_keypoint; ++rank) {
      AddMatch(keypoint_idx, rank == correct_rank, seen_in_anchor, distance_m);
    }
  }

  void AddMatch(int keypoint_idx, bool correct, const Eigen::Vector3d& seen_in_anchor,
                double distance_m) {
    Correspondence match;
    match.keypoint_idx = keypoint_idx;
    match.landmark_idx = static_cast<uint32_t>(scene_.correspondences.size());
    match.sigma_m = static_cast<float>(options_.landmark_noise_m);
    double azimuth_rad = Uniform(-kPi, kPi);
    double size_distance_m = Uniform(options_.min_depth_m, options_.max_depth_m);
    double scale_px = std::exp(Uniform(std::log(1.5), std::log(15.0)));
    match.x_in_anchor = InRegion(50.0, 0.0, 15.0);
    if (correct) {
      const Eigen::Vector3d to_camera = scene_.center_in_anchor() - seen_in_anchor;
      azimuth_rad = std::atan2(to_camera.y(), to_camera.x()) + Normal(options_.azimuth_noise_rad);
      size_distance_m = distance_m * std::exp(Normal(options_.log_size_noise));
      scale_px = scene_.query.keypoints[keypoint_idx].scale_px;
      match.x_in_anchor = seen_in_anchor + Normal3(options_.landmark_noise_m);
    }
    match.azimuth_rad = static_cast<float>(WrapAngleRad(azimuth_rad));
    match.size_m = static_cast<float>(scale_px / options_.camera.focal_px() * size_distance_m);
    scene_.correspondences.push_back(match);
    scene_.is_correct.push_back(correct);
  }

  PoseSceneOptions options_;
  std::mt19937_64 engine_;
  PoseScene scene_;
};

// 4,000 matches of 1,000 keypoints, gravity off by 1 degree.
inline PoseSceneOptions HardScene(int num_inliers) {
  PoseSceneOptions options;
  options.num_keypoints = 1000;
  options.matches_per_keypoint = 4;
  options.num_inliers = num_inliers;
  options.pixel_noise_px = 1.0;
  options.gravity_noise_rad = 0.0175;
  options.landmark_noise_m = 0.05;
  return options;
}

inline PoseScene MakePoseScene(const PoseSceneOptions& options) {
  return PoseSceneBuilder(options).Build();
}

// Two cameras up to 2 m beside the first, which look left and right.
inline std::vector<QueryRigCamera> SideCameras() {
  std::vector<QueryRigCamera> cameras;
  for (const double side : {-1.0, 1.0}) {
    const Eigen::Quaterniond rotation(
        Eigen::AngleAxisd(side * 1.4, Eigen::Vector3d(0.05, 1.0, 0.1 * side).normalized()));
    const Camera camera(CameraModel::kPinhole, 800, 600, {450.0, 450.0, 400.0, 300.0});
    cameras.push_back({camera, Rigid3d(rotation, {side * 2.0, 0.3, -0.5})});
  }
  return cameras;
}

// Returns the distance between two camera centers.
inline double CenterErrorM(const Rigid3d& a_cam_from_anchor, const Rigid3d& b_cam_from_anchor) {
  return (a_cam_from_anchor.Inverse().translation - b_cam_from_anchor.Inverse().translation).norm();
}

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_SUPPORT_POSE_SCENE_H_
