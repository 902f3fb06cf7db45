#include "lab/city/detector.h"

#include <algorithm>
#include <cmath>

#include "core/angles.h"
#include "core/require.h"
#include "core/scene/triangulate.h"
#include "lab/city/hashed_random.h"

namespace cairn {
namespace {

// Pixels per meter at the reference distance of a descriptor: 10 m with a focal length of 400
// pixels.
constexpr double kReferencePxPerM = 40.0;
// Response lost by a slanted view: foreshortened surfaces lose contrast.
constexpr double kSlantPenalty = 1.5;
constexpr double kCrowdSectorRad = kPi / 12.0;
constexpr double kCrowdDistanceM = 4.0;
constexpr double kCrowdTopRad = 0.05;  // Height above the horizon.

// Streams of random numbers that must stay separate.
enum LookStream : uint64_t {
  kLookStream = 0x301,
  kCrowdStream,
  kNoiseStream,
};

struct Candidate {
  const CityLandmark* landmark;
  Eigen::Vector3d x_in_cam;
  Eigen::Vector2d pixel;
  double scale_px;
  double response;
};

class Detector {
 public:
  Detector(const CityRegion& region, const Camera& camera, const Rigid3d& cam_from_site,
           const DetectorOptions& options, uint64_t image_id, uint64_t place_id)
      : region_(region),
        camera_(camera),
        rotation_(cam_from_site.rotation.toRotationMatrix()),
        center_(cam_from_site.Inverse().translation),
        options_(options),
        image_id_(image_id),
        place_id_(place_id),
        min_cos_(std::cos(options.max_view_angle_rad)) {}

  std::vector<Detection> Detect() {
    for (const RegionSurface& surface : region_.surfaces()) {
      if (MayBeSeen(surface)) {
        Look(surface);
      }
    }
    std::sort(candidates_.begin(), candidates_.end(), [](const Candidate& a, const Candidate& b) {
      return a.response != b.response ? a.response > b.response : a.landmark->id < b.landmark->id;
    });
    std::vector<Detection> detections;
    for (const Candidate& candidate : candidates_) {
      if (static_cast<int>(detections.size()) == options_.max_keypoints) {
        break;
      }
      if (!IsInCrowd(candidate) && !region_.IsHidden(center_, candidate.landmark->x_in_site)) {
        detections.push_back(See(candidate));
      }
    }
    return detections;
  }

 private:
  // A quick test that errs toward true.
  bool MayBeSeen(const RegionSurface& surface) const {
    const Eigen::Vector2d to_middle = surface.middle - center_.head<2>();
    const double reach_m = options_.max_range_m + surface.radius_m;
    if (to_middle.squaredNorm() > reach_m * reach_m || surface.landmarks.empty()) {
      return false;
    }
    if (surface.surface.kind == SurfaceKind::kTree ||
        surface.surface.kind == SurfaceKind::kGround) {
      return true;
    }
    constexpr double kStandsOutM = 0.5;
    const Eigen::Vector2d outwards(surface.surface.along.y(), -surface.surface.along.x());
    return outwards.dot(to_middle) < kStandsOutM;
  }

  void Look(const RegionSurface& surface) {
    const double to_middle_m = (surface.middle - center_.head<2>()).norm();
    const double least_range_m = std::max(0.5, to_middle_m - surface.radius_m);
    // The magnification in an image is largest in its corners.
    const double corner_stretch = CornerStretch();
    const double least_size_m =
        options_.min_scale_px * least_range_m / (camera_.focal_px() * corner_stretch);
    for (const CityLandmark& landmark : surface.landmarks) {
      if (landmark.size_m < least_size_m) {
        break;
      }
      Consider(landmark);
    }
  }

  double CornerStretch() const {
    const double tangent =
        std::hypot(camera_.width_px(), camera_.height_px()) / (2.0 * camera_.focal_px());
    return std::pow(1.0 + tangent * tangent, 0.75);
  }

  void Consider(const CityLandmark& landmark) {
    const Eigen::Vector3d to_camera = center_ - landmark.x_in_site;
    const double sq_range = to_camera.squaredNorm();
    if (sq_range > options_.max_range_m * options_.max_range_m || sq_range < 0.25) {
      return;
    }
    const double range_m = std::sqrt(sq_range);
    const double cos_slant = landmark.normal.cast<double>().dot(to_camera) / range_m;
    if (cos_slant < min_cos_) {
      return;
    }
    const Eigen::Vector3d x_in_cam = -(rotation_ * to_camera);
    if (x_in_cam.z() < 0.2) {
      return;
    }
    const auto pixel = camera_.Project(x_in_cam);
    if (!pixel || !camera_.Contains(*pixel)) {
      return;
    }
    // Off the axis, a pinhole camera magnifies by 1 / cos along the circle and by 1 / cos^2 across
    // it.
    const double stretch = std::pow(range_m / x_in_cam.z(), 1.5);
    const double scale_px =
        landmark.size_m * camera_.focal_px() / range_m * stretch * std::sqrt(cos_slant);
    if (scale_px < options_.min_scale_px || scale_px > options_.max_scale_px) {
      return;
    }
    HashedRandom random(HashOf(image_id_, kLookStream, landmark.id));
    const double response = landmark.salience + options_.response_noise * random.Normal() -
                            kSlantPenalty * (1.0 - cos_slant);
    if (response > 0.0) {
      candidates_.push_back({&landmark, x_in_cam, *pixel, scale_px, response});
    }
  }

  bool IsInCrowd(const Candidate& candidate) const {
    const Eigen::Vector3d way = candidate.landmark->x_in_site - center_;
    const double ground_range_m = way.head<2>().norm();
    if (ground_range_m < kCrowdDistanceM || way.z() > kCrowdTopRad * ground_range_m) {
      return false;
    }
    const auto sector =
        static_cast<int64_t>(std::floor(std::atan2(way.y(), way.x()) / kCrowdSectorRad));
    return HashedRandom(HashOf(place_id_, kCrowdStream, sector)).Chance(options_.crowd_share);
  }

  Detection See(const Candidate& candidate) const {
    const CityLandmark& landmark = *candidate.landmark;
    HashedRandom random(HashOf(image_id_, kNoiseStream, landmark.id));
    Detection detection;
    detection.landmark = &landmark;
    detection.range_m = candidate.x_in_cam.norm();
    const double sigma_px = options_.position_noise * KeypointSigmaPx(candidate.scale_px);
    const double x_px = candidate.pixel.x() + sigma_px * random.Normal();
    const double y_px = candidate.pixel.y() + sigma_px * random.Normal();
    detection.keypoint.x_px = static_cast<float>(std::clamp<double>(x_px, 0.0, camera_.width_px()));
    detection.keypoint.y_px =
        static_cast<float>(std::clamp<double>(y_px, 0.0, camera_.height_px()));
    detection.keypoint.scale_px = static_cast<float>(
        candidate.scale_px * std::exp(options_.log_scale_sigma * random.Normal()));
    detection.keypoint.orientation_rad = static_cast<float>(OrientationRad(candidate, &random));
    FillLook(candidate, &detection.look);
    return detection;
  }

  double OrientationRad(const Candidate& candidate, HashedRandom* random) const {
    const Eigen::Vector3d pointer = rotation_ * candidate.landmark->pointer.cast<double>();
    // Derivative of the projection along the pointer.
    const Eigen::Vector2d in_image =
        pointer.head<2>() - pointer.z() / candidate.x_in_cam.z() * candidate.x_in_cam.head<2>();
    double orientation_rad =
        std::atan2(in_image.y(), in_image.x()) + options_.orientation_sigma_rad * random->Normal();
    if (random->Chance(options_.other_orientation_share)) {
      orientation_rad += random->Uniform(-kPi, kPi);
    }
    return WrapAngleRad(orientation_rad);
  }

  void FillLook(const Candidate& candidate, DescriptorLook* look) const {
    const CityLandmark& landmark = *candidate.landmark;
    const Eigen::Vector3d normal = landmark.normal.cast<double>();
    const Eigen::Vector3d to_camera = center_ - landmark.x_in_site;
    // A normal that points up has no azimuth. The pointer takes its place.
    const bool lies = std::abs(normal.z()) > 0.9;
    const Eigen::Vector3d ahead = lies ? Eigen::Vector3d(landmark.pointer.cast<double>()) : normal;
    look->ornament = landmark.ornament;
    look->landmark = landmark.id;
    look->view_azimuth_rad =
        WrapAngleRad(std::atan2(to_camera.y(), to_camera.x()) - std::atan2(ahead.y(), ahead.x()));
    look->view_elevation_rad = std::atan2(to_camera.z(), to_camera.head<2>().norm());
    look->log2_scale = std::log2(camera_.focal_px() / (to_camera.norm() * kReferencePxPerM));
    look->observation = image_id_;
  }

  const CityRegion& region_;
  const Camera& camera_;
  Eigen::Matrix3d rotation_;
  Eigen::Vector3d center_;
  const DetectorOptions& options_;
  uint64_t image_id_, place_id_;
  double min_cos_;
  std::vector<Candidate> candidates_;
};

}  // namespace

void DetectorOptions::Validate() const {
  RequireWithin("detector.max_range_m", max_range_m, 1.0, 300.0);
  RequireWithin("detector.max_view_angle_rad", max_view_angle_rad, 0.1, 1.5);
  RequireWithin("detector.min_scale_px", min_scale_px, 0.3, 20.0);
  RequireWithin("detector.max_scale_px", max_scale_px, min_scale_px, 200.0);
  RequireWithin("detector.max_keypoints", max_keypoints, 1, 20'000);
  RequireWithin("detector.position_noise", position_noise, 0.0, 20.0);
  RequireWithin("detector.log_scale_sigma", log_scale_sigma, 0.0, 2.0);
  RequireWithin("detector.orientation_sigma_rad", orientation_sigma_rad, 0.0, 3.0);
  RequireWithin("detector.other_orientation_share", other_orientation_share, 0.0, 1.0);
  RequireWithin("detector.response_noise", response_noise, 0.0, 10.0);
  RequireWithin("detector.crowd_share", crowd_share, 0.0, 1.0);
}

std::vector<Detection> DetectLandmarks(const CityRegion& region, const Camera& camera,
                                       const Rigid3d& cam_from_site, const DetectorOptions& options,
                                       uint64_t image_id, uint64_t place_id) {
  return Detector(region, camera, cam_from_site, options, image_id, place_id).Detect();
}

}  // namespace cairn
