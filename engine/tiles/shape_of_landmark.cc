#include "engine/tiles/shape_of_landmark.h"

#include <Eigen/LU>
#include <cmath>

#include "core/rigid3.h"
#include "storage/tile/tile.h"

namespace cairn {
namespace {

// Relative to what the keyframes know together, the least that they know of any direction. Keeps
// the distance finite of a landmark that one keyframe saw.
constexpr double kLeastInformation = 1e-5;
// The mean of the directions from the keyframes to the landmark is at least this long if they see
// it from one side.
constexpr double kLeastMeanRay = 0.1;

}  // namespace

LandmarkShape ShapeOfLandmark(const SearchableTile& tile, uint32_t landmark_idx) {
  const TileLandmarks& landmarks = tile.landmarks();
  const Eigen::Vector3d x_in_tile = landmarks.x_in_tile[landmark_idx].cast<double>();
  const auto keyframes = tile.covisibility().keyframes;
  // Of keyframes whose focal lengths and keypoints are alike: each measures two directions, the
  // more precisely the nearer it stands.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d sum_of_rays = Eigen::Vector3d::Zero();
  int num_rays = 0;
  for (const uint32_t k :
       tile.landmark_keyframes().KeyframesThatSaw(landmarks.landmark_ids[landmark_idx])) {
    const Eigen::Vector3d to_landmark =
        x_in_tile - keyframes[k].cam_from_tile.Inverse().translation;
    const double sq_distance = to_landmark.squaredNorm();
    if (sq_distance > 0.0) {
      const Eigen::Vector3d ray = to_landmark / std::sqrt(sq_distance);
      information += (Eigen::Matrix3d::Identity() - ray * ray.transpose()) / sq_distance;
      sum_of_rays += ray;
      ++num_rays;
    }
  }
  const double sigma_m = SigmaFromCode(landmarks.sigma_codes[landmark_idx]);
  LandmarkShape shape = {sigma_m * sigma_m * Eigen::Matrix3d::Identity()};
  if (num_rays == 0) {
    return shape;
  }
  information += kLeastInformation * information.trace() * Eigen::Matrix3d::Identity();
  shape.covariance_sq_m = information.inverse();
  shape.covariance_sq_m *= 3.0 * sigma_m * sigma_m / shape.covariance_sq_m.trace();
  if (sum_of_rays.norm() > kLeastMeanRay * num_rays) {
    const Eigen::Vector3d away = shape.covariance_sq_m * sum_of_rays;
    shape.by_distance_m = away / std::sqrt(sum_of_rays.dot(away));
  }
  return shape;
}

}  // namespace cairn
