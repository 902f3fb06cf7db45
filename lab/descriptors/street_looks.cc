#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "cli/demo/street/build_street.h"
#include "cli/demo/street/renderer.h"
#include "core/parallel_for.h"
#include "lab/descriptors/look_collector.h"
#include "lab/descriptors/real_looks.h"

namespace cairn {
namespace {

constexpr int kNumThreads = 2;
constexpr double kMaxDepthM = 60.0;
// Largest relative gap between the ray's end and the point.
constexpr double kOcclusionShare = 0.02;
// Limits for repetitions.
constexpr int kRepeatPhotoStep = 7;
constexpr double kMaxHeightDifferenceM = 0.03;
constexpr double kMaxLog2SizeRatio = 0.2;
constexpr double kMaxTurnRad = 0.15;
constexpr double kMinApartM = 0.5;
constexpr double kMaxFrontOffsetM = 0.01;

// A point on the street's surface that a keypoint shows, with its normal. Null for the sky.
struct SurfaceHit {
  Eigen::Vector3d x_in_world;
  Eigen::Vector3d normal_in_world;
};

std::optional<Eigen::Vector3d> CastRay(const Renderer& renderer, const PosedImage& image,
                                       const Eigen::Vector2d& pixel) {
  const Eigen::Vector3d ray =
      image.cam_from_world.rotation.conjugate() * *image.camera->Unproject(pixel);
  const double distance_m = renderer.FreeSightM(image.center_in_world, ray);
  if (distance_m > kMaxDepthM) {
    return std::nullopt;
  }
  return image.center_in_world + distance_m * ray;
}

// Requires that the whole keypoint lies in one plane.
std::optional<SurfaceHit> HitSurface(const Renderer& renderer, const PosedImage& image,
                                     const Keypoint& keypoint) {
  const Eigen::Vector2d pixel(keypoint.x_px, keypoint.y_px);
  const double radius_px = 4.0 * keypoint.scale_px;
  std::vector<Eigen::Vector3d> hits;
  for (const Eigen::Vector2d& corner :
       {Eigen::Vector2d(0, 0), Eigen::Vector2d(-1, -1), Eigen::Vector2d(1, -1),
        Eigen::Vector2d(1, 1), Eigen::Vector2d(-1, 1)}) {
    const Eigen::Vector2d at = pixel + radius_px * corner;
    const std::optional<Eigen::Vector3d> hit =
        image.camera->Contains(at) ? CastRay(renderer, image, at) : std::nullopt;
    if (!hit) {
      return std::nullopt;
    }
    hits.push_back(*hit);
  }
  Eigen::Vector3d normal = (hits[3] - hits[1]).cross(hits[4] - hits[2]).normalized();
  if (normal.dot(image.center_in_world - hits[0]) < 0.0) {
    normal = -normal;
  }
  for (const Eigen::Vector3d& hit : hits) {
    if (std::abs(normal.dot(hit - hits[0])) > 1e-3) {
      return std::nullopt;
    }
  }
  return SurfaceHit{hits[0], normal};
}

std::optional<Anchor> AnchorOnStreet(const Renderer& renderer, const PosedImage& image,
                                     const Keypoint& keypoint) {
  const std::optional<SurfaceHit> hit = HitSurface(renderer, image, keypoint);
  if (!hit || std::abs(hit->normal_in_world.z()) > 0.5) {  // The ground has no azimuth.
    return std::nullopt;
  }
  const double radius_px = 2.0 * keypoint.scale_px;
  const std::optional<Eigen::Vector3d> ahead =
      CastRay(renderer, image,
              Eigen::Vector2d(keypoint.x_px + radius_px * std::cos(keypoint.orientation_rad),
                              keypoint.y_px + radius_px * std::sin(keypoint.orientation_rad)));
  if (!ahead) {
    return std::nullopt;
  }
  const double depth_m = DepthOf(image, hit->x_in_world);
  return Anchor{.x_in_world = hit->x_in_world,
                .axes_from_world = AxesAbout(hit->normal_in_world, Eigen::Vector3d::UnitZ()),
                .along_in_world = *ahead - hit->x_in_world,
                .size = keypoint.scale_px * depth_m / image.camera->focal_px(),
                .depth = depth_m,
                .orientation_rad = keypoint.orientation_rad};
}

std::vector<PosedImage> PhotographStreet(const StreetScene& scene) {
  std::vector<StreetPhoto> photos = scene.TakePhotos(scene.MappingPoses(), "map", kNumThreads);
  for (StreetPhoto& photo : scene.TakePhotos(scene.QueryPoses(), "query", kNumThreads)) {
    photos.push_back(std::move(photo));
  }
  std::vector<PosedImage> images(photos.size());
  ParallelFor(static_cast<int>(photos.size()), kNumThreads, [&](int i) {
    images[i] = {.camera = &scene.camera(),
                 .cam_from_world = photos[i].cam_from_enu,
                 .center_in_world = photos[i].cam_from_enu.Inverse().translation,
                 .features = ExtractSift(photos[i].image, {.max_features = 1500})};
  });
  return images;
}

bool MayRepeat(const Anchor& a, const Anchor& b) {
  const Eigen::Vector3d apart = a.axes_from_world * (b.x_in_world - a.x_in_world);
  return std::abs(apart.x()) >= kMinApartM && std::abs(apart.y()) <= kMaxHeightDifferenceM &&
         std::abs(apart.z()) <= kMaxFrontOffsetM &&
         std::abs(std::log2(a.size / b.size)) <= kMaxLog2SizeRatio &&
         std::abs(WrapAngleRad(a.orientation_rad - b.orientation_rad)) <= kMaxTurnRad;
}

}  // namespace

RealLooks LooksAtStreet(const StreetOptions& street, const RealLooksOptions& options) {
  options.Validate();
  const StreetScene scene(street);
  const Renderer renderer(BuildStreet(street));
  const std::vector<PosedImage> images = PhotographStreet(scene);
  std::vector<std::pair<int, int>> keypoints;  // Pairs of (image, keypoint).
  for (int i = 0; i < static_cast<int>(scene.MappingPoses().size()); ++i) {
    for (int k = 0; k < images[i].features.size(); ++k) {
      keypoints.emplace_back(i, k);
    }
  }
  LookCollector collector(images, options);
  for (size_t i = 0; i < keypoints.size(); i += StepFor(keypoints.size(), options.max_landmarks)) {
    const auto [image_idx, keypoint_idx] = keypoints[i];
    const std::optional<Anchor> anchor = AnchorOnStreet(
        renderer, images[image_idx], images[image_idx].features.keypoints[keypoint_idx]);
    if (!anchor) {
      continue;
    }
    collector.Add(*anchor, image_idx, keypoint_idx, [&](int other) {
      const Eigen::Vector3d ray = anchor->x_in_world - images[other].center_in_world;
      return renderer.FreeSightM(images[other].center_in_world, ray.normalized()) >
             (1.0 - kOcclusionShare) * ray.norm();
    });
  }
  return collector.Finish();
}

RealLooks RepeatsOnStreet(const StreetOptions& street) {
  const StreetScene scene(street);
  const Renderer renderer(BuildStreet(street));
  const std::vector<PosedImage> images = PhotographStreet(scene);
  const RealLooksOptions options;
  LookCollector collector(images, options);
  int num_ornaments = 0;
  for (int i = 0; i < static_cast<int>(images.size()); i += kRepeatPhotoStep) {
    std::vector<std::pair<int, Anchor>> anchors;
    for (int k = 0; k < images[i].features.size(); ++k) {
      const auto anchor = AnchorOnStreet(renderer, images[i], images[i].features.keypoints[k]);
      if (anchor) {
        anchors.emplace_back(k, *anchor);
      }
    }
    for (size_t a = 0; a < anchors.size(); ++a) {
      for (size_t b = a + 1; b < anchors.size(); ++b) {
        if (MayRepeat(anchors[a].second, anchors[b].second)) {
          collector.Append(anchors[a].second, num_ornaments, 2 * num_ornaments, i,
                           anchors[a].first);
          collector.Append(anchors[b].second, num_ornaments, 2 * num_ornaments + 1, i,
                           anchors[b].first);
          ++num_ornaments;
        }
      }
    }
  }
  return collector.Finish();
}

}  // namespace cairn
