// Simulated walks with a phone that is held in any way, for tests of which way is up.
#ifndef CAIRN_TESTS_INGEST_SIMULATED_WALK_H_
#define CAIRN_TESTS_INGEST_SIMULATED_WALK_H_

#include <fmt/format.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/angles.h"
#include "core/error.h"
#include "core/frames.h"
#include "core/scene/reconstruction.h"
#include "ingest/place/georegister.h"
#include "support/reconstruction_builder.h"

namespace cairn::testing {

enum class WalkShape { kBend, kLoop };

struct WalkOptions {
  double length_m = 80.0;
  WalkShape shape = WalkShape::kBend;
  double bend_rad = 0.0;  // Turn of the walk at its middle; 0 is a straight walk.
  int num_photos = 27;
  double gps_sigma_m = 3.0;
  double yaw_sigma_rad = 0.03, pitch_sigma_rad = 0.03, roll_sigma_rad = 0.03;
  double pitch_rad = 0.0;
  double side_rad = 0.0;   // Of the views, from ahead; positive is to the left.
  double swing_rad = 0.0;  // Views alternate so far to both sides.
  bool has_facades = true;
  double left_wall_m = 8.0, right_wall_m = 8.0;
  double ground_share = 1.0;  // Of the points of the ground that become landmarks.
  bool feels_gravity = false;
  bool is_mirrored = false;  // By a program that wrote the photos.
  std::function<PictureUp(int)> held = [](int) { return PictureUp::kTop; };
  uint64_t seed = 1;
};

struct Walk {
  Reconstruction reconstruction;
  std::vector<CameraPosition> positions;
  Eigen::Vector3d up_in_world;

  // Degrees between the true up and that of a georegistration.
  double TiltDeg(const Georegistration& found) const;
};

inline std::function<PictureUp(int)> All(PictureUp up) {
  return [up](int) { return up; };
}

// One of many kinds of walks, by its seed.
struct DrawnWalk {
  WalkOptions options;
  ImageOrientations orientations;
  std::string name;  // Of its kind, for people.
};
struct WalkShot {
  Eigen::Vector3d x_in_enu;
  double heading_rad = 0.0;  // Of the walk.
  double azimuth_rad = 0.0;
  double pitch_rad = 0.0;
  PictureUp held = PictureUp::kTop;
};

inline double RollOf(PictureUp held) {
  switch (held) {
    case PictureUp::kLeft:
      return -0.5 * kPi;
    case PictureUp::kRight:
      return 0.5 * kPi;
    case PictureUp::kBottom:
      return kPi;
    default:
      return 0.0;
  }
}

inline Rigid3d RolledBy(double roll_rad) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitZ())),
          Eigen::Vector3d::Zero()};
}

// The place and heading after a share of the walk.
inline WalkShot PlaceOf(const WalkOptions& options, double share) {
  WalkShot shot;
  if (options.shape == WalkShape::kLoop) {
    const double angle_rad = 2.0 * kPi * share;
    const double radius_m = options.length_m / (2.0 * kPi);
    shot.x_in_enu = {radius_m * std::sin(angle_rad), -radius_m * std::cos(angle_rad), 0.0};
    shot.heading_rad = angle_rad;
    return shot;
  }
  const double along_m = options.length_m * (share - 0.5);
  shot.heading_rad = along_m > 0.0 ? options.bend_rad : 0.0;
  shot.x_in_enu = {along_m * std::cos(shot.heading_rad), along_m * std::sin(shot.heading_rad), 0.0};
  return shot;
}

// Points of the facades at both sides and of the ground 1.6 m below.
inline void AddObservations(const WalkOptions& options, size_t image_idx, const WalkShot& shot,
                            const Rigid3d& cam_from_enu, const Sim3d& world_from_enu,
                            std::mt19937_64* rng, Reconstruction* reconstruction) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const Rigid3d enu_from_cam = cam_from_enu.Inverse();
  const Eigen::Vector3d left_in_enu(-std::sin(shot.heading_rad), std::cos(shot.heading_rad), 0.0);
  for (int k = 0; k < 200; ++k) {
    const Eigen::Vector3d ray_in_enu =
        enu_from_cam.rotation *
        Eigen::Vector3d(0.8 * (2.0 * uniform(*rng) - 1.0), 0.6 * (2.0 * uniform(*rng) - 1.0), 1.0);
    const double left = ray_in_enu.dot(left_in_enu);
    const double wall_m = left > 0.0 ? options.left_wall_m : options.right_wall_m;
    const double to_wall = wall_m / std::max(0.05, std::abs(left));
    const double to_ground = ray_in_enu.z() < -0.01 ? 1.6 / -ray_in_enu.z() : 1e9;
    const double depth = std::min({to_wall, to_ground, 60.0});
    const Eigen::Vector3d x_in_enu = enu_from_cam.translation + depth * ray_in_enu;
    const bool is_bare = depth == to_ground && uniform(*rng) > options.ground_share;
    if (x_in_enu.z() < 12.0 && !is_bare) {
      reconstruction->landmarks.push_back(
          {world_from_enu * x_in_enu, {{static_cast<int>(image_idx), 0}}});
    }
  }
}

// What COLMAP makes of the same photos with left and right exchanged.
inline void Mirror(Walk* walk) {
  for (ReconImage& image : walk->reconstruction.images) {
    Rigid3d& pose = image.cam_from_world;
    const Eigen::Quaterniond& q = pose.rotation;
    pose.rotation = Eigen::Quaterniond(q.w(), q.x(), -q.y(), -q.z());
    pose.translation.x() *= -1.0;
  }
  for (ReconLandmark& landmark : walk->reconstruction.landmarks) {
    landmark.x_in_world.x() *= -1.0;
  }
  walk->up_in_world.x() *= -1.0;
}

inline int OrientationOf(PictureUp held) {
  switch (held) {
    case PictureUp::kLeft:
      return 6;
    case PictureUp::kRight:
      return 8;
    case PictureUp::kBottom:
      return 3;
    default:
      return 1;
  }
}

inline double Walk::TiltDeg(const Georegistration& found) const {
  const Eigen::Vector3d up_in_ecef =
      EcefFromEnu(positions[0].position).rotation * Eigen::Vector3d::UnitZ();
  const double cosine = (found.ecef_from_world.rotation * up_in_world).dot(up_in_ecef);
  return std::acos(std::clamp(cosine, -1.0, 1.0)) * kDegPerRad;
}

// A walk between facades that are 12 m high, over ground 1.6 m below the camera.
inline Walk MakeWalk(const WalkOptions& options) {
  std::mt19937_64 rng(options.seed);
  std::normal_distribution<double> normal(0.0, 1.0);
  const Sim3d world_from_enu = {
      0.2, Eigen::Quaterniond(normal(rng), normal(rng), normal(rng), normal(rng)).normalized(),
      Eigen::Vector3d(3.0, -2.0, 7.0)};
  const Rigid3d ecef_from_enu = EcefFromEnu(Geodetic::FromDegrees(47.3769, 8.5417, 408.0));
  Walk walk;
  walk.up_in_world = world_from_enu.rotation * Eigen::Vector3d::UnitZ();
  walk.reconstruction.cameras = {
      Camera(CameraModel::kPinhole, 640, 480, {400.0, 400.0, 320.0, 240.0})};
  for (int i = 0; i < options.num_photos; ++i) {
    WalkShot shot = PlaceOf(options, i / (options.num_photos - 1.0));
    shot.x_in_enu.z() += 0.05 * normal(rng);
    shot.azimuth_rad = shot.heading_rad + options.side_rad + options.swing_rad * (i % 3 - 1) +
                       options.yaw_sigma_rad * normal(rng);
    shot.pitch_rad = options.pitch_rad + options.pitch_sigma_rad * normal(rng);
    const Rigid3d cam_from_enu =
        RolledBy(RollOf(options.held(i)) + options.roll_sigma_rad * normal(rng)) *
        StreetWorld::LookAlong(shot.x_in_enu, shot.azimuth_rad, shot.pitch_rad);
    ReconImage image;
    image.name = std::to_string(i);
    image.cam_from_world = CamFromTarget(cam_from_enu, world_from_enu);
    if (options.feels_gravity) {
      image.down_in_cam = cam_from_enu.rotation * -Eigen::Vector3d::UnitZ();
    }
    image.features.keypoints.resize(1);
    image.features.descriptors = DescriptorMatrix(DescriptorMatrix::Zero(1, 128));
    walk.reconstruction.images.push_back(std::move(image));
    const double sigma_m = options.gps_sigma_m;
    const Eigen::Vector3d error(sigma_m * normal(rng), sigma_m * normal(rng),
                                2.0 * sigma_m * normal(rng));
    walk.positions.push_back({std::to_string(i),
                              GeodeticFromEcef(ecef_from_enu * (shot.x_in_enu + error)),
                              std::max(0.05, 1.5 * sigma_m)});
    if (options.has_facades) {
      AddObservations(options, walk.reconstruction.images.size() - 1, shot, cam_from_enu,
                      world_from_enu, &rng, &walk.reconstruction);
    }
  }
  if (options.is_mirrored) {
    Mirror(&walk);
  }
  return walk;
}

// What cameras write that know how they were held.
inline ImageOrientations ExifOf(const WalkOptions& options) {
  ImageOrientations orientations;
  for (int i = 0; i < options.num_photos; ++i) {
    orientations.emplace_back(OrientationOf(options.held(i)));
  }
  return orientations;
}

// "right", "wrong", "refused" or "refused as mirrored". A right up errs by less than 20 degrees.
// Adds ", said" if the summary says that the model may be mirrored.
inline std::string OutcomeOf(const WalkOptions& options, const GeoregisterOptions& georegister = {},
                             const ImageOrientations& orientations = {}) {
  constexpr double kMaxTiltDeg = 20.0;
  const Walk walk = MakeWalk(options);
  try {
    const Georegistration found =
        Georegister(walk.reconstruction, walk.positions, georegister, orientations);
    const bool is_said = found.up.source.find("mirrored") != std::string::npos;
    return std::string(walk.TiltDeg(found) < kMaxTiltDeg ? "right" : "wrong") +
           (is_said ? ", said" : "");
  } catch (const Error& e) {
    const std::string message = e.what();
    if (message.find("--up") == std::string::npos) {
      return "refused";
    }
    return message.find("mirrored") == std::string::npos ? "refused" : "refused as mirrored";
  }
}

// As some program leaves them: "none", "true", "half" (of the photos have none) or "all 1".
inline ImageOrientations OrientationsOf(const WalkOptions& walk, const std::string& kind) {
  ImageOrientations orientations = kind == "none" ? ImageOrientations() : ExifOf(walk);
  for (size_t i = 0; i < orientations.size(); ++i) {
    if (kind == "all 1") {
      orientations[i] = 1;
    } else if (kind == "half" && i % 2 == 1) {
      orientations[i].reset();
    }
  }
  return orientations;
}

inline DrawnWalk DrawWalk(uint64_t seed) {
  std::mt19937_64 rng(seed * 7919 + 13);
  const auto draw = [&](int count) { return static_cast<int>(rng() % count); };
  DrawnWalk drawn;
  WalkOptions& walk = drawn.options;
  walk.seed = seed;
  if (draw(2) == 0) {
    walk.length_m = 30.0;
    walk.num_photos = 8;
  }
  constexpr std::array<const char*, 7> kShapes = {
      "straight", "bent by 6", "bent by 17", "bent by 46", "L", "loop", "sidewalk"};
  const int shape = draw(7);
  walk.bend_rad = std::array{0.0, 0.1, 0.3, 0.8, 0.5 * kPi, 0.0, 0.0}[shape];
  walk.shape = shape == 5 ? WalkShape::kLoop : WalkShape::kBend;
  if (shape == 6) {
    walk.right_wall_m = 2.0;
    walk.left_wall_m = 14.0;
  }
  constexpr std::array<const char*, 4> kPitches = {"ahead", "down by 17", "down by 45",
                                                   "down by 86"};
  const int pitch = draw(4);
  walk.pitch_rad = -std::array{0.0, 0.3, 0.8, 1.5}[pitch];
  constexpr std::array<const char*, 3> kViews = {"along", "aside", "around"};
  const int view = std::array{0, 0, 1, 2}[draw(4)];
  walk.side_rad = view == 1 ? 0.5 * kPi : 0.0;
  walk.swing_rad = view == 2 ? 0.8 : 0.0;
  constexpr std::array<const char*, 8> kHolds = {
      "top",         "left",           "right",         "bottom",
      "top or left", "left, some top", "left or right", "bottom, some top"};
  const int hold = draw(8);
  constexpr std::array kFirst = {PictureUp::kTop,    PictureUp::kLeft, PictureUp::kRight,
                                 PictureUp::kBottom, PictureUp::kTop,  PictureUp::kTop,
                                 PictureUp::kLeft,   PictureUp::kTop};
  constexpr std::array kOther = {PictureUp::kTop,    PictureUp::kLeft,  PictureUp::kRight,
                                 PictureUp::kBottom, PictureUp::kLeft,  PictureUp::kLeft,
                                 PictureUp::kRight,  PictureUp::kBottom};
  const int every = hold == 5 || hold == 7 ? 4 : 2;
  walk.held = [hold, every, kFirst, kOther](int i) {
    return i % every == 0 ? kFirst[hold] : kOther[hold];
  };
  walk.gps_sigma_m = draw(2) == 0 ? 1.0 : 5.0;
  constexpr std::array<const char*, 4> kExifs = {"none", "true", "half", "all 1"};
  const int exif = draw(4);
  drawn.orientations = OrientationsOf(walk, kExifs[exif]);
  const int scene = draw(4);
  walk.has_facades = scene > 0;
  walk.ground_share = scene == 1 ? 0.2 : 1.0;
  drawn.name = fmt::format(
      "{}; {} m; {}; {}; held {}; gps {}; exif {}; {}", kShapes[shape], walk.length_m,
      kPitches[pitch], kViews[view], kHolds[hold], walk.gps_sigma_m, kExifs[exif],
      std::array{"no observations", "bare ground", "observations", "observations"}[scene]);
  return drawn;
}

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_INGEST_SIMULATED_WALK_H_
