// Photos of a facade by cameras of their own, and their two views, without any descriptor.
#ifndef CAIRN_TESTS_MAPPING_FACADE_VIEWS_H_
#define CAIRN_TESTS_MAPPING_FACADE_VIEWS_H_

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/focal_length.h"
#include "mapping/matching/two_view.h"
#include "mapping/photo_set.h"

namespace cairn::testing {

// Where a photo was taken, seen from above: the facade is 30 m wide, at z = 30 m, with reliefs of
// 6 m, and cameras look at about its middle.
struct FacadePhoto {
  double x_m = 0.0, z_m = 0.0;
  double focal_factor = 1.0;  // Relative to the guess.
};

struct FacadeViews {
  PhotoSet set;  // A camera a photo, with a guessed focal length.
  std::vector<TwoView> views;
  std::vector<Rigid3d> cam_from_world;
};

inline std::vector<Eigen::Vector3d> FacadePoints(int count, std::mt19937_64* rng) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < count; ++i) {
    const double x_m = 30.0 * unit(*rng) - 15.0, y_m = 12.0 * unit(*rng) - 8.0;
    points.emplace_back(x_m, y_m, 30.0 + 6.0 * unit(*rng));
  }
  return points;
}

// `is_matched` says whether the keypoints of two photos that show a point are matched.
inline FacadeViews MakeFacadeViews(
    const std::vector<FacadePhoto>& photos,
    const std::function<bool(int photo_a, int photo_b, int point)>& is_matched,
    int num_points = 600) {
  FacadeViews world;
  std::mt19937_64 rng(3);
  const std::vector<Eigen::Vector3d> points = FacadePoints(num_points, &rng);
  std::normal_distribution<double> noise(0.0, 0.3);
  std::vector<std::vector<int>> keypoint_of_point;
  for (const FacadePhoto& source : photos) {
    // If all axes met in one point, no pair could tell focal lengths.
    const double phase = static_cast<double>(world.set.photos.size());
    const Eigen::Vector3d center(source.x_m, 1.5 * std::sin(2.0 * phase), source.z_m);
    const double yaw =
        std::atan2(-source.x_m, 33.0 - source.z_m) + 0.12 * std::sin(3.0 * phase + 1.0);
    const double pitch = 0.12 * std::cos(2.0 * phase);
    const Eigen::Quaterniond cam_from_world(Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitX()) *
                                            Eigen::AngleAxisd(-yaw, Eigen::Vector3d::UnitY()));
    world.cam_from_world.emplace_back(cam_from_world, -(cam_from_world * center));
    const Camera guess = CameraOfUnknownFocal(1000, 750);
    const Camera truth = WithFocalScaled(guess, source.focal_factor);
    MappingPhoto photo;
    photo.name = std::to_string(world.set.photos.size()) + ".jpg";
    photo.camera_idx = static_cast<int>(world.set.cameras.size());
    world.set.cameras.push_back({guess, FocalPrior{.with_distortion = true}, FocalSource::kGuess});
    keypoint_of_point.emplace_back(num_points, -1);
    for (int i = 0; i < num_points; ++i) {
      const auto pixel = truth.Project(world.cam_from_world.back() * points[i]);
      if (pixel && truth.Contains(*pixel)) {
        keypoint_of_point.back()[i] = static_cast<int>(photo.keypoints.size());
        photo.keypoints.push_back({static_cast<float>(pixel->x() + noise(rng)),
                                   static_cast<float>(pixel->y() + noise(rng)), 2.0f, 0.0f});
      }
    }
    photo.descriptors =
        ByteDescriptorMatrix(ByteDescriptorMatrix::Zero(photo.keypoints.size(), 128));
    world.set.photos.push_back(std::move(photo));
  }
  for (int a = 0; a < static_cast<int>(photos.size()); ++a) {
    for (int b = a + 1; b < static_cast<int>(photos.size()); ++b) {
      TwoView view;
      view.a = a;
      view.b = b;
      view.b_from_a = world.cam_from_world[b] * world.cam_from_world[a].Inverse();
      view.parallax_rad = std::min(1.0, view.b_from_a.translation.norm() / 33.0);
      view.b_from_a.translation.normalize();
      view.rotation_sigma_rad = view.direction_sigma_rad = 0.005;
      for (int i = 0; i < num_points; ++i) {
        const int p = keypoint_of_point[a][i], q = keypoint_of_point[b][i];
        if (p >= 0 && q >= 0 && is_matched(a, b, i)) {
          view.inliers.push_back({p, q, 0.1f});
        }
      }
      if (view.inliers.size() >= 15) {
        world.views.push_back(std::move(view));
      }
    }
  }
  return world;
}

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_MAPPING_FACADE_VIEWS_H_
