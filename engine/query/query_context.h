// What every stage needs of a query, computed once.
#ifndef CAIRN_ENGINE_QUERY_QUERY_CONTEXT_H_
#define CAIRN_ENGINE_QUERY_QUERY_CONTEXT_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/camera.h"
#include "core/features.h"
#include "core/geodesy.h"
#include "core/rigid3.h"

namespace cairn {

// Where in the world the camera may be, in the query's anchor frame: east-north-up at `origin`.
struct SearchRegion {
  Geodetic origin;  // Ellipsoidal height 0.
  Rigid3d ecef_from_anchor;
  bool has_prior = false;  // If not, the region is the whole map, up to the tile limit.
  Eigen::Vector2d prior_xy_in_anchor = Eigen::Vector2d::Zero();  // Meaningful with a prior.
  double prior_sigma_m = 0.0;  // Per axis, from the 68 % radius of a circular Gaussian.
  double radius_m = 0.0;       // Horizontal bound of the search about prior_xy_in_anchor.
  // Heights (z in anchor) at which the camera may be. Set by `tiles` from the keyframes' heights,
  // narrowed by the prior's own height where it has one.
  double min_z_m = -1e4;
  double max_z_m = 1e4;
};

// A further camera of a rig.
struct QueryRigCamera {
  Camera camera;
  Rigid3d cam_from_first;
};

// Per-keypoint arrays hold the features of the query's own camera, then those of the other cameras
// in turn. The frame `cam` is that of the own camera. Immutable once built.
struct QueryContext {
  Camera camera;
  std::vector<Keypoint> keypoints;  // In the pixels of the camera that saw them.
  DescriptorMatrix descriptors;     // num_keypoints x projected_dim.
  // Half of the pairs of descriptors of one landmark are nearer to each other; projected space, 0
  // if not known.
  double same_landmark_distance = 0.0;
  std::vector<Eigen::Vector3d> rays_in_cam;  // Unit; a zero vector if not invertible.
  // Rigs only, else all empty.
  std::vector<QueryRigCamera> other_cameras;
  std::vector<uint8_t> camera_of_keypoint;      // 0 is `camera`, i is other_cameras[i - 1].
  std::vector<Eigen::Vector3d> origins_in_cam;  // Per keypoint: where its ray starts.
  std::vector<std::optional<float>> gravity_orientations_rad;  // All empty without gravity.
  std::optional<Eigen::Vector3d> down_in_cam;
  // Rotation that turns the camera so that down_in_cam becomes (0, 0, -1): level is z-up, its x
  // axis is the horizontal part of the viewing direction (or, looking straight up or down, of the
  // image's y axis). Present with gravity. anchor_from_level is a rotation by yaw about z.
  std::optional<Eigen::Quaterniond> level_from_cam;
  SearchRegion region;

  int num_keypoints() const { return static_cast<int>(keypoints.size()); }
  bool is_rig() const { return !other_cameras.empty(); }
  int num_cameras() const { return 1 + static_cast<int>(other_cameras.size()); }
  int CameraIdxOf(int keypoint_idx) const {
    return is_rig() ? camera_of_keypoint[keypoint_idx] : 0;
  }
  const Camera& CameraAt(int camera_idx) const {
    return camera_idx == 0 ? camera : other_cameras[camera_idx - 1].camera;
  }
  const Camera& CameraOf(int keypoint_idx) const { return CameraAt(CameraIdxOf(keypoint_idx)); }
  // From the frame `cam` into that of a camera.
  Rigid3d OwnFromFirst(int camera_idx) const {
    return camera_idx == 0 ? Rigid3d() : other_cameras[camera_idx - 1].cam_from_first;
  }
  Eigen::Vector3d OriginInCam(int keypoint_idx) const {
    return is_rig() ? origins_in_cam[keypoint_idx] : Eigen::Vector3d::Zero();
  }
  // A point of `cam` in the frame of the camera that saw the keypoint.
  Eigen::Vector3d InCameraOf(int keypoint_idx, const Eigen::Vector3d& x_in_cam) const {
    const int camera_idx = CameraIdxOf(keypoint_idx);
    return camera_idx == 0 ? x_in_cam : other_cameras[camera_idx - 1].cam_from_first * x_in_cam;
  }
};

// A 2D-3D match: keypoint to landmark.
struct Correspondence {
  int keypoint_idx = 0;
  int tile_idx = 0;             // Into the query's tiles.
  uint32_t landmark_idx = 0;    // Into that tile.
  Eigen::Vector3d x_in_anchor;  // Landmark position.
  float sq_distance = 0.0f;     // Of the descriptors, with the weighted prior terms added.
  float sigma_m = 0.0f;         // Landmark position standard deviation.
  float azimuth_rad = 0.0f;     // From landmark to mapping camera of the matched descriptor.
  float size_m = 0.0f;          // Physical size of the matched keypoint.
  float descriptor_sq_distance = 0.0f;   // Of the descriptors alone.
  std::optional<float> orientation_rad;  // Gravity-rectified, of the matched descriptor.
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_QUERY_QUERY_CONTEXT_H_
