#include "ingest/place/keyframe_features.h"

#include <cmath>
#include <limits>
#include <optional>

#include "core/frames.h"
#include "core/geodesy.h"
#include "core/keypoint_shape.h"
#include "core/rigid3.h"

namespace cairn {
namespace {

// The descriptor of the landmark that was seen from the direction nearest to the azimuth.
uint32_t NearestDescriptor(const Tile& tile, uint32_t landmark_idx, double azimuth_rad) {
  uint32_t nearest = tile.descriptor_begin[landmark_idx];
  double least_rad = std::numeric_limits<double>::max();
  for (uint32_t d = nearest; d < tile.descriptor_begin[landmark_idx + 1]; ++d) {
    const double turn_rad =
        std::abs(WrapAngleRad(azimuth_rad - AzimuthFromCode(tile.azimuth_codes[d])));
    if (turn_rad < least_rad) {
      least_rad = turn_rad;
      nearest = d;
    }
  }
  return nearest;
}

// The direction of a keypoint in the image whose gravity-rectified orientation a tile has; unknown
// where the tile has none.
double ImageOrientationRad(const Camera& camera, const Eigen::Vector2d& pixel, uint8_t code,
                           const Eigen::Vector3d& down_in_cam) {
  const Keypoint along_x = {static_cast<float>(pixel.x()), static_cast<float>(pixel.y()), 1.0f,
                            0.0f};
  const std::optional<double> rectified_rad =
      GravityRectifiedOrientationRad(camera, along_x, down_in_cam);
  return code == kNoOrientation || !rectified_rad
             ? kUnknownOrientationRad
             : WrapAngleRad(OrientationFromCode(code) - *rectified_rad);
}

}  // namespace

KeyframeFeatures FeaturesOfKeyframe(const Tile& tile, size_t keyframe_idx, const Camera& camera,
                                    const DescriptorMatrix& descriptors) {
  const Rigid3d& cam_from_tile = tile.keyframes[keyframe_idx].cam_from_tile;
  const Eigen::Vector3d center_in_tile = cam_from_tile.Inverse().translation;
  const Rigid3d ecef_from_tile = EcefFromEnu(tile.id.Anchor());
  const Rigid3d enu_from_tile =
      EcefFromEnu(GeodeticFromEcef(ecef_from_tile * center_in_tile)).Inverse() * ecef_from_tile;
  const Eigen::Vector3d down_in_cam =
      cam_from_tile.rotation * (enu_from_tile.rotation.conjugate() * DownInEnu());

  KeyframeFeatures seen;
  std::vector<uint32_t> rows;
  for (const uint32_t landmark_idx : tile.LandmarksOfKeyframe(keyframe_idx)) {
    const Eigen::Vector3d x_in_tile = tile.x_in_tile[landmark_idx].cast<double>();
    const Eigen::Vector3d x_in_cam = cam_from_tile * x_in_tile;
    const auto pixel = x_in_cam.z() > 0.0 ? camera.Project(x_in_cam) : std::nullopt;
    const bool has_descriptor =
        tile.descriptor_begin[landmark_idx] < tile.descriptor_begin[landmark_idx + 1];
    if (!has_descriptor || !pixel || !camera.Contains(*pixel)) {
      continue;
    }
    const Eigen::Vector3d to_camera = center_in_tile - x_in_tile;
    const uint32_t d =
        NearestDescriptor(tile, landmark_idx, std::atan2(to_camera.y(), to_camera.x()));
    const double scale_px = SizeFromCode(tile.size_codes[d]) * camera.focal_px() / to_camera.norm();
    seen.features.keypoints.push_back(
        {static_cast<float>(pixel->x()), static_cast<float>(pixel->y()),
         static_cast<float>(scale_px),
         static_cast<float>(
             ImageOrientationRad(camera, *pixel, tile.orientation_codes[d], down_in_cam))});
    seen.landmarks.push_back(landmark_idx);
    rows.push_back(d);
  }
  seen.features.space = DescriptorSpace::kProjected;
  seen.features.descriptors.resize(static_cast<Eigen::Index>(rows.size()), descriptors.cols());
  for (size_t i = 0; i < rows.size(); ++i) {
    seen.features.descriptors.row(static_cast<Eigen::Index>(i)) = descriptors.row(rows[i]);
  }
  return seen;
}

}  // namespace cairn
