#include "cli/demo/street/street_scene.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <random>
#include <utility>

#include "cli/demo/street/build_street.h"
#include "cli/demo/street/renderer.h"
#include "core/angles.h"
#include "core/parallel_for.h"
#include "core/require.h"

namespace cairn {
namespace {

// A viewing direction in the street: yaw counterclockwise from the street's x axis, pitch up, roll
// clockwise about the viewing direction.
struct Gaze {
  double yaw_rad, pitch_rad, roll_rad;
};

Rigid3d CamFromStreet(const Eigen::Vector3d& center_in_street, const Gaze& gaze) {
  const double cos_pitch = std::cos(gaze.pitch_rad);
  const Eigen::Vector3d forward(std::cos(gaze.yaw_rad) * cos_pitch,
                                std::sin(gaze.yaw_rad) * cos_pitch, std::sin(gaze.pitch_rad));
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d level_cam_from_street;
  level_cam_from_street << right.transpose(), forward.cross(right).transpose(), forward.transpose();
  const Eigen::Quaterniond cam_from_street =
      Eigen::AngleAxisd(-gaze.roll_rad, Eigen::Vector3d::UnitZ()) *
      Eigen::Quaterniond(level_cam_from_street);
  return {cam_from_street, -(cam_from_street * center_in_street)};
}

// Returns true if nothing is closer than `distance_m` in front of the camera.
bool HasFreeSight(const Renderer& renderer, const Camera& camera, const Rigid3d& cam_from_enu,
                  double distance_m) {
  constexpr int kNumRays = 6;  // Along each image axis.
  const Rigid3d enu_from_cam = cam_from_enu.Inverse();
  for (int i = 0; i < kNumRays * kNumRays; ++i) {
    const Eigen::Vector2d pixel((i % kNumRays + 0.5) / kNumRays * camera.width_px(),
                                (i / kNumRays + 0.5) / kNumRays * camera.height_px());
    const Eigen::Vector3d ray_in_enu = enu_from_cam.rotation * *camera.Unproject(pixel);
    if (renderer.FreeSightM(enu_from_cam.translation, ray_in_enu) < distance_m) {
      return false;
    }
  }
  return true;
}

double SqDistanceToRect(const TexturedRect& rect, const Eigen::Vector3d& x_in_enu) {
  const Eigen::Vector3d offset = x_in_enu - rect.corner_in_enu;
  const double u = std::clamp(offset.dot(rect.u_in_enu) / rect.u_in_enu.squaredNorm(), 0.0, 1.0);
  const double v = std::clamp(offset.dot(rect.v_in_enu) / rect.v_in_enu.squaredNorm(), 0.0, 1.0);
  return (offset - u * rect.u_in_enu - v * rect.v_in_enu).squaredNorm();
}

Geodetic NoisyGps(const StreetOptions& options, const Eigen::Vector3d& center_in_enu,
                  std::mt19937_64* rng) {
  std::normal_distribution<double> noise_m(0.0, options.gps_sigma_m);
  const double east = noise_m(*rng), north = noise_m(*rng), up = noise_m(*rng);
  return GeodeticFromEcef(EcefFromEnu(options.origin) *
                          (center_in_enu + Eigen::Vector3d(east, north, up)));
}

}  // namespace

void StreetOptions::Validate() const {
  ValidateGeodetic(origin, "street origin");
  RequireOption(std::isfinite(heading_rad), "street.heading_rad must be finite");
  RequireWithin("street.length_m", length_m, 40.0, 1000.0);
  RequireWithin("street.width_m", width_m, 12.0, 60.0);
  RequireWithin("street.mapping_step_m", mapping_step_m, 0.5, 20.0);
  RequireWithin("street.num_queries", num_queries, 1, 10000);
  RequireWithin("street.image_width_px", image_width_px, 64, 8192);
  RequireWithin("street.image_height_px", image_height_px, 64, 8192);
  RequireWithin("street.focal_px", focal_px, 32.0, 1e5);
  RequireWithin("street.num_trees", num_trees, 0, 1000);
  RequireWithin("street.gps_sigma_m", gps_sigma_m, 0.0, 1000.0);
}

struct StreetScene::Impl {
  StreetOptions options;
  Camera camera;
  Renderer renderer;
};

StreetScene::StreetScene(const StreetOptions& options) {
  options.Validate();
  const Camera camera(CameraModel::kPinhole, options.image_width_px, options.image_height_px,
                      {options.focal_px, options.focal_px, 0.5 * options.image_width_px,
                       0.5 * options.image_height_px});
  impl_ = std::make_unique<Impl>(Impl{options, camera, Renderer(BuildStreet(options))});
}

StreetScene::~StreetScene() = default;

const StreetOptions& StreetScene::options() const { return impl_->options; }

const Camera& StreetScene::camera() const { return impl_->camera; }

GrayImage StreetScene::Render(const Rigid3d& cam_from_enu, uint64_t photo_seed) const {
  std::mt19937_64 rng(impl_->options.seed ^ (photo_seed * 0x9E3779B97F4A7C15ull));
  PhotoEffects effects;
  effects.gain = std::exp(std::normal_distribution<double>(0.0, 0.1)(rng));
  effects.noise_seed = rng();
  return impl_->renderer.Render(impl_->camera, cam_from_enu, effects);
}

std::vector<StreetPhoto> StreetScene::TakePhotos(
    const std::vector<Rigid3d>& cams_from_enu, const std::string& prefix, int num_threads,
    const std::function<void(int, int)>& progress) const {
  const int num_photos = static_cast<int>(cams_from_enu.size());
  std::vector<StreetPhoto> photos(num_photos);
  // The prefix separates a query's noise from that of the mapping photo with the same number.
  std::seed_seq prefix_seed(prefix.begin(), prefix.end());
  std::mt19937_64 rng(prefix_seed);
  const uint64_t first_seed = rng() ^ impl_->options.seed;
  for (int i = 0; i < num_photos; ++i) {
    photos[i].name = fmt::format("{}{:03d}.png", prefix, i);
    photos[i].cam_from_enu = cams_from_enu[i];
    photos[i].gps = NoisyGps(impl_->options, cams_from_enu[i].Inverse().translation, &rng);
  }
  std::mutex mutex;
  int num_done = 0;
  ParallelFor(num_photos, num_threads, [&](int i) {
    photos[i].image = Render(cams_from_enu[i], first_seed + static_cast<uint64_t>(i));
    const std::lock_guard<std::mutex> lock(mutex);
    ++num_done;
    if (progress) {
      progress(num_done, num_photos);
    }
  });
  return photos;
}

std::vector<Rigid3d> StreetScene::MappingPoses() const {
  const StreetOptions& options = impl_->options;
  const Rigid3d street_from_enu = EnuFromStreet(options).Inverse();
  std::mt19937_64 rng(options.seed + 1);
  std::normal_distribution<double> normal;
  constexpr double kEndMarginM = 5.0;
  const double drive_m = options.length_m - 2.0 * kEndMarginM;
  const int num_stops = static_cast<int>(drive_m / options.mapping_step_m) + 1;
  std::vector<Rigid3d> poses;
  for (const double direction : {1.0, -1.0}) {
    for (int stop = 0; stop < num_stops; ++stop) {
      const double along_m = direction * (stop * options.mapping_step_m - 0.5 * drive_m);
      const Eigen::Vector3d center(0.5 * options.length_m + along_m + 0.2 * normal(rng),
                                   -direction * 1.9 + 0.25 * normal(rng), 2.2);
      const double heading = (direction > 0.0 ? 0.0 : 180.0) + 1.5 * normal(rng);
      for (const double yaw_deg : {0.0, 62.0, -62.0}) {
        const Gaze gaze = {(heading + yaw_deg) * kRadPerDeg, (7.0 + normal(rng)) * kRadPerDeg,
                           normal(rng) * kRadPerDeg};
        poses.push_back(CamFromStreet(center, gaze) * street_from_enu);
      }
    }
  }
  return poses;
}

std::vector<Rigid3d> StreetScene::QueryPoses() const {
  const StreetOptions& options = impl_->options;
  const Rigid3d street_from_enu = EnuFromStreet(options).Inverse();
  std::mt19937_64 rng(options.seed + 2);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  constexpr double kEndMarginM = 12.0;
  const double walk_m = options.length_m - 2.0 * kEndMarginM;
  std::vector<Rigid3d> poses;
  for (int i = 0; i < options.num_queries; ++i) {
    const double side = i % 3 == 2 ? -1.0 : 1.0;  // Sometimes crosses the street.
    // Nobody photographs the back of a kiosk. If something stands in the way, try a few steps
    // further on.
    for (int attempt = 0; attempt < 20; ++attempt) {
      const double share = (i + 0.5 + 0.4 * uniform(rng)) / options.num_queries;
      const Eigen::Vector3d center(kEndMarginM + share * walk_m,
                                   side * (0.5 * options.width_m - 2.0 + 0.3 * uniform(rng)),
                                   1.55 + 0.1 * uniform(rng));
      // From along the street to straight across it, to either side.
      const double across_deg = 20.0 + 35.0 * (1.0 + uniform(rng));
      const double yaw_deg = -side * (i % 2 ? 180.0 - across_deg : across_deg);
      const Gaze gaze = {yaw_deg * kRadPerDeg, (8.0 + 4.0 * normal(rng)) * kRadPerDeg,
                         3.0 * normal(rng) * kRadPerDeg};
      const Rigid3d cam_from_enu = CamFromStreet(center, gaze) * street_from_enu;
      if (attempt == 0) {
        poses.push_back(cam_from_enu);
      }
      if (HasFreeSight(impl_->renderer, impl_->camera, cam_from_enu, 2.5)) {
        poses.back() = cam_from_enu;
        break;
      }
    }
  }
  return poses;
}

double StreetScene::DistanceToSurfaceM(const Eigen::Vector3d& x_in_enu) const {
  double sq_distance = std::numeric_limits<double>::infinity();
  for (const TexturedRect& rect : impl_->renderer.rects()) {
    sq_distance = std::min(sq_distance, SqDistanceToRect(rect, x_in_enu));
  }
  return std::sqrt(sq_distance);
}

}  // namespace cairn
