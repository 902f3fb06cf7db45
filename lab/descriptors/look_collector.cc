#include "lab/descriptors/look_collector.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "storage/codebook/descriptor_codec.h"

namespace cairn {
namespace {

constexpr int kDim = 128;
constexpr double kMaxLog2Nearer = 2.5;
constexpr double kMaxViewRad = 1.4;  // Between the normal and the ray.

double OrientationIn(const PosedImage& image, const Anchor& anchor,
                     const Eigen::Vector2d& projected) {
  if (anchor.along_in_world.isZero()) {
    return anchor.orientation_rad;
  }
  const std::optional<Eigen::Vector2d> ahead =
      image.camera->Project(image.cam_from_world * (anchor.x_in_world + anchor.along_in_world));
  return ahead ? std::atan2(ahead->y() - projected.y(), ahead->x() - projected.x())
               : std::numeric_limits<double>::quiet_NaN();
}

// Returns the keypoint that corresponds geometrically to the landmark, or -1.
int KeypointAt(const PosedImage& image, const Anchor& anchor, const RealLooksOptions& options) {
  const double depth = DepthOf(image, anchor.x_in_world);
  const std::optional<Eigen::Vector2d> projected =
      image.camera->Project(image.cam_from_world * anchor.x_in_world);
  const double log2_nearer = std::log2(anchor.depth / depth);
  if (!projected || !image.camera->Contains(*projected) || std::abs(log2_nearer) > kMaxLog2Nearer) {
    return -1;
  }
  const double orientation_rad = OrientationIn(image, anchor, *projected);
  const Eigen::Vector2d sought = *projected + options.offset_px;
  double least_px = options.max_distance_px;
  int nearest = -1;
  for (int i = 0; i < image.features.size(); ++i) {
    const Keypoint& keypoint = image.features.keypoints[i];
    const double distance_px = std::hypot(keypoint.x_px - sought.x(), keypoint.y_px - sought.y());
    if (distance_px > least_px) {
      continue;
    }
    const double size = keypoint.scale_px * depth / image.camera->focal_px();
    const double turn_rad = WrapAngleRad(keypoint.orientation_rad - orientation_rad);
    if (std::abs(std::log2(size / anchor.size)) <= options.max_log2_size_ratio &&
        std::abs(turn_rad) <= options.max_orientation_rad) {
      least_px = distance_px;
      nearest = i;
    }
  }
  return nearest;
}

RealLook LookFrom(const PosedImage& image, const Anchor& anchor) {
  const Eigen::Vector3d ray =
      anchor.axes_from_world * (image.center_in_world - anchor.x_in_world).normalized();
  return {.azimuth_rad = static_cast<float>(std::atan2(ray.x(), ray.z())),
          .elevation_rad = static_cast<float>(std::asin(std::clamp(ray.y(), -1.0, 1.0))),
          .log2_scale = static_cast<float>(
              std::log2(image.camera->focal_px() / DepthOf(image, anchor.x_in_world)))};
}

}  // namespace

double DepthOf(const PosedImage& image, const Eigen::Vector3d& x_in_world) {
  return (image.cam_from_world * x_in_world).z();
}

Eigen::Matrix3d AxesAbout(const Eigen::Vector3d& out, const Eigen::Vector3d& up) {
  Eigen::Matrix3d axes;
  axes.row(2) = out.normalized();
  axes.row(0) = up.cross(out).normalized();
  axes.row(1) = axes.row(2).cross(axes.row(0));
  return axes;
}

size_t StepFor(size_t count, int max_count) {
  return std::max<size_t>(1, (count + max_count - 1) / static_cast<size_t>(max_count));
}

void LookCollector::Add(const Anchor& anchor, int first_image, int first_keypoint,
                        const std::function<bool(int image)>& is_visible) {
  const int landmark = num_landmarks_++;
  Append(anchor, landmark, landmark, first_image, first_keypoint);
  for (int i = 0; i < static_cast<int>(images_.size()); ++i) {
    const Eigen::Vector3d ray = (images_[i].center_in_world - anchor.x_in_world).normalized();
    if (i == first_image || anchor.axes_from_world.row(2).dot(ray) < std::cos(kMaxViewRad) ||
        !is_visible(i)) {
      continue;
    }
    const int keypoint = KeypointAt(images_[i], anchor, options_);
    if (keypoint >= 0) {
      Append(anchor, landmark, landmark, i, keypoint);
    }
  }
}

void LookCollector::Append(const Anchor& anchor, int ornament, int landmark, int image,
                           int keypoint) {
  RealLook look = LookFrom(images_[image], anchor);
  look.ornament = ornament;
  look.landmark = landmark;
  look.image = image;
  looks_.push_back(look);
  keypoints_.push_back(keypoint);
}

RealLooks LookCollector::Finish() {
  RealLooks result;
  result.looks = std::move(looks_);
  result.root.resize(result.size(), kDim);
  for (int i = 0; i < result.size(); ++i) {
    result.root.row(i) = images_[result.looks[i].image].features.descriptors.row(keypoints_[i]);
  }
  NormalizeDescriptors(DescriptorNormalization::kRootSift, &result.root);
  return result;
}

}  // namespace cairn
