// The data of a query that all stages need, computed once.
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

// The region where the camera may be, in the query's anchor frame: east-north-up at `origin`.
struct SearchRegion {
  Geodetic origin;  // Ellipsoidal height 0.
  Rigid3d ecef_from_anchor;
  // If false, the region is a place of the map where the photo may have been taken.
  bool has_prior = false;
  Eigen::Vector2d prior_xy_in_anchor = Eigen::Vector2d::Zero();  // Meaningful if has_prior.
  double prior_sigma_m = 0.0;  // Per axis, from the 68 % radius of a circular Gaussian.
  double radius_m = 0.0;       // Horizontal bound of the search around prior_xy_in_anchor.
  // Without a prior, the area that the camera may be in, square meters: that of the whole map.
  double area_m2 = 0.0;
  // Range of the camera's height (z in anchor). Stage `tiles` sets it from the keyframes' heights
  // and narrows it by the prior's height, if any.
  double min_z_m = -1e4;
  double max_z_m = 1e4;
};

// Another camera of a rig.
struct QueryRigCamera {
  Camera camera;
  Rigid3d cam_from_first;
};

// Per-keypoint arrays hold the features of the query's own camera, followed by those of the other
// cameras in order. The frame `cam` is that of the query's own camera. Immutable once built.
struct QueryContext {
  Camera camera;
  std::vector<Keypoint> keypoints;  // In the pixels of the camera that saw them.
  DescriptorMatrix descriptors;     // num_keypoints x projected_dim.
  // The median distance between descriptors of one landmark, in projected space; 0 if unknown.
  double same_landmark_distance = 0.0;
  std::vector<Eigen::Vector3d> rays_in_cam;  // Unit vectors; a zero vector if the pixel has no ray.
  // The next three are empty unless the query is a rig's.
  std::vector<QueryRigCamera> other_cameras;
  std::vector<uint8_t> camera_of_keypoint;      // 0 is `camera`, i is other_cameras[i - 1].
  std::vector<Eigen::Vector3d> origins_in_cam;  // Per keypoint, where its ray starts.
  // Gravity-rectified; no element is set without gravity.
  std::vector<std::optional<float>> gravity_orientations_rad;
  std::optional<Eigen::Vector3d> down_in_cam;
  // The rotation that maps down_in_cam to (0, 0, -1). The frame level is z-up. Its x axis is the
  // horizontal part of the viewing direction, or of the image's y axis if the camera looks straight
  // up or down. Set if the query has gravity. anchor_from_level is then a rotation by yaw about z.
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
  // Transforms from the frame `cam` to the frame of a camera.
  Rigid3d OwnFromFirst(int camera_idx) const {
    return camera_idx == 0 ? Rigid3d() : other_cameras[camera_idx - 1].cam_from_first;
  }
  Eigen::Vector3d OriginInCam(int keypoint_idx) const {
    return is_rig() ? origins_in_cam[keypoint_idx] : Eigen::Vector3d::Zero();
  }
  // Transforms a point from `cam` to the frame of the camera that saw the keypoint.
  Eigen::Vector3d InCameraOf(int keypoint_idx, const Eigen::Vector3d& x_in_cam) const {
    const int camera_idx = CameraIdxOf(keypoint_idx);
    return camera_idx == 0 ? x_in_cam : other_cameras[camera_idx - 1].cam_from_first * x_in_cam;
  }
};

// A 2D-3D match between a keypoint and a landmark.
struct Correspondence {
  int keypoint_idx = 0;
  int tile_idx = 0;             // Index into the query's tiles.
  uint32_t landmark_idx = 0;    // Index into that tile's landmarks.
  Eigen::Vector3d x_in_anchor;  // Landmark position.
  float sq_distance = 0.0f;     // Of the descriptors, including the weighted prior terms.
  float sigma_m = 0.0f;         // Standard deviation of the landmark position.
  // Direction from the landmark to the mapping camera of the matched descriptor.
  float azimuth_rad = 0.0f;
  float size_m = 0.0f;                   // Physical size of the matched keypoint; 0: unknown.
  float descriptor_sq_distance = 0.0f;   // Of the descriptors alone.
  std::optional<float> orientation_rad;  // Gravity-rectified orientation of the matched descriptor.
  // The area of the image in which the keypoint of the landmark was sought, given a pose, square
  // pixels; 0 if no pose was given and the landmark may lie anywhere.
  float search_area_sq_px = 0.0f;
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_QUERY_QUERY_CONTEXT_H_
