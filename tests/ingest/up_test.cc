// Which way is up: walks with a phone held in every way, straight and bent, with rough positions.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "core/angles.h"
#include "core/error.h"
#include "core/frames.h"
#include "ingest/place/georegister.h"
#include "support/reconstruction_builder.h"

namespace cairn {
namespace {

using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::Ne;
using testing::StreetWorld;

struct Shot {
  Eigen::Vector3d x_in_enu;
  double azimuth_rad = 0.0;
  double pitch_rad = 0.0;
  PictureUp held = PictureUp::kTop;
};

// The pose in which the stored picture is turned as `held`.
Rigid3d PoseOf(const Shot& shot) {
  const Rigid3d level = StreetWorld::LookAlong(shot.x_in_enu, shot.azimuth_rad, shot.pitch_rad);
  double roll_rad = 0.0;
  switch (shot.held) {
    case PictureUp::kLeft:
      roll_rad = -0.5 * kPi;
      break;
    case PictureUp::kRight:
      roll_rad = 0.5 * kPi;
      break;
    case PictureUp::kBottom:
      roll_rad = kPi;
      break;
    default:
      break;
  }
  const Rigid3d turn{Eigen::Quaterniond(Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitZ())),
                     Eigen::Vector3d::Zero()};
  return turn * level;
}

struct WalkOptions {
  double length_m = 80.0;
  double bend_rad = 0.0;  // Turn of the walk at its middle.
  int num_photos = 27;
  double gps_sigma_m = 3.0;
  double yaw_sigma_rad = 0.03, pitch_sigma_rad = 0.03, roll_sigma_rad = 0.03;
  double pitch_rad = 0.0;
  double side_rad = 0.0;   // Of the views, from ahead.
  double swing_rad = 0.0;  // Views alternate so far to both sides.
  bool has_facades = true;
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
  double TiltDeg(const Georegistration& found) const {
    const Eigen::Vector3d up_in_ecef =
        EcefFromEnu(positions[0].position).rotation * Eigen::Vector3d::UnitZ();
    const double cosine = (found.ecef_from_world.rotation * up_in_world).dot(up_in_ecef);
    return std::acos(std::clamp(cosine, -1.0, 1.0)) * kDegPerRad;
  }
};

// Points of facades 8 m to both sides and of the ground 1.6 m below.
void AddSights(const WalkOptions& options, const std::vector<Rigid3d>& cam_from_enu,
               const Sim3d& world_from_enu, std::mt19937_64* rng, Reconstruction* reconstruction) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (size_t i = 0; i < cam_from_enu.size() && options.has_facades; ++i) {
    const Rigid3d enu_from_cam = cam_from_enu[i].Inverse();
    for (int k = 0; k < 200; ++k) {
      const Eigen::Vector3d ray_in_enu =
          enu_from_cam.rotation * Eigen::Vector3d(0.8 * (2.0 * uniform(*rng) - 1.0),
                                                  0.6 * (2.0 * uniform(*rng) - 1.0), 1.0);
      const double to_wall = 8.0 / std::max(0.05, std::abs(ray_in_enu.y()));
      const double to_ground = ray_in_enu.z() < -0.01 ? 1.6 / -ray_in_enu.z() : 1e9;
      const double depth = std::min({to_wall, to_ground, 60.0});
      const Eigen::Vector3d x_in_enu = enu_from_cam.translation + depth * ray_in_enu;
      if (x_in_enu.z() < 12.0) {
        reconstruction->landmarks.push_back(
            {world_from_enu * x_in_enu, {{static_cast<int>(i), 0}}});
      }
    }
  }
}

// What COLMAP makes of the same photos with left and right exchanged.
void Mirror(Walk* walk) {
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

Walk MakeWalk(const WalkOptions& options) {
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
  std::vector<Rigid3d> cam_from_enu;
  for (int i = 0; i < options.num_photos; ++i) {
    const double along_m = options.length_m * (i / (options.num_photos - 1.0) - 0.5);
    const double heading_rad = along_m > 0.0 ? options.bend_rad : 0.0;
    Shot shot;
    shot.x_in_enu = {along_m * std::cos(heading_rad), along_m * std::sin(heading_rad),
                     0.05 * normal(rng)};
    shot.azimuth_rad = heading_rad + options.side_rad + options.swing_rad * (i % 3 - 1) +
                       options.yaw_sigma_rad * normal(rng);
    shot.pitch_rad = options.pitch_rad + options.pitch_sigma_rad * normal(rng);
    shot.held = options.held(i);
    const Rigid3d shake{Eigen::Quaterniond(Eigen::AngleAxisd(options.roll_sigma_rad * normal(rng),
                                                             Eigen::Vector3d::UnitZ())),
                        Eigen::Vector3d::Zero()};
    cam_from_enu.push_back(shake * PoseOf(shot));
    ReconImage image;
    image.name = std::to_string(i);
    image.cam_from_world = CamFromTarget(cam_from_enu.back(), world_from_enu);
    if (options.feels_gravity) {
      image.down_in_cam = cam_from_enu.back().rotation * -Eigen::Vector3d::UnitZ();
    }
    image.features.keypoints.resize(1);
    image.features.descriptors = DescriptorMatrix::Zero(1, 128);
    walk.reconstruction.images.push_back(std::move(image));
    const double sigma_m = options.gps_sigma_m;
    const Eigen::Vector3d error(sigma_m * normal(rng), sigma_m * normal(rng),
                                2.0 * sigma_m * normal(rng));
    walk.positions.push_back({std::to_string(i),
                              GeodeticFromEcef(ecef_from_enu * (shot.x_in_enu + error)),
                              std::max(0.05, 1.5 * sigma_m)});
  }
  AddSights(options, cam_from_enu, world_from_enu, &rng, &walk.reconstruction);
  if (options.is_mirrored) {
    Mirror(&walk);
  }
  return walk;
}

// "right", "wrong", "refused" or "refused as mirrored".
std::string OutcomeOf(const WalkOptions& options, const GeoregisterOptions& georegister = {},
                      const ImageOrientations& orientations = {}) {
  constexpr double kMaxTiltDeg = 20.0;
  const Walk walk = MakeWalk(options);
  try {
    const Georegistration found =
        Georegister(walk.reconstruction, walk.positions, georegister, orientations);
    return walk.TiltDeg(found) < kMaxTiltDeg ? "right" : "wrong";
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), HasSubstr("--up"));
    return std::string(e.what()).find("mirrored") == std::string::npos ? "refused"
                                                                       : "refused as mirrored";
  }
}

// For each of three seeds.
std::vector<std::string> OutcomesOf(WalkOptions options, const GeoregisterOptions& georegister = {},
                                    const ImageOrientations& orientations = {}) {
  std::vector<std::string> outcomes;
  for (options.seed = 1; options.seed <= 3; ++options.seed) {
    outcomes.push_back(OutcomeOf(options, georegister, orientations));
  }
  return outcomes;
}

// What cameras write that know how they were held.
ImageOrientations ExifOf(const WalkOptions& options) {
  ImageOrientations orientations;
  for (int i = 0; i < options.num_photos; ++i) {
    const PictureUp up = options.held(i);
    orientations.emplace_back(up == PictureUp::kLeft     ? 6
                              : up == PictureUp::kRight  ? 8
                              : up == PictureUp::kBottom ? 3
                                                         : 1);
  }
  return orientations;
}

std::function<PictureUp(int)> All(PictureUp up) {
  return [up](int) { return up; };
}

PictureUp TopOrLeft(int i) { return i % 2 == 0 ? PictureUp::kTop : PictureUp::kLeft; }

TEST(WhichWayIsUp, APhoneLyingOrUprightOrBothOnAStraightStreet) {
  EXPECT_THAT(OutcomesOf({}), Each("right"));
  EXPECT_THAT(OutcomesOf({.held = All(PictureUp::kLeft)}), Each("right"));
  EXPECT_THAT(OutcomesOf({.held = TopOrLeft}), Each("right"));
}

TEST(WhichWayIsUp, APhoneUpsideDownOnAStraightStreetIsNeverWrong) {
  EXPECT_THAT(OutcomesOf({.held = All(PictureUp::kRight)}), Each(Ne("wrong")));
  EXPECT_THAT(OutcomesOf({.held = All(PictureUp::kBottom)}), Each(Ne("wrong")));
}

TEST(WhichWayIsUp, ABendTellsHoweverThePhoneIsHeld) {
  for (const PictureUp up :
       {PictureUp::kTop, PictureUp::kLeft, PictureUp::kRight, PictureUp::kBottom}) {
    EXPECT_THAT(OutcomesOf({.bend_rad = 0.8, .has_facades = false, .held = All(up)}),
                Each("right"));
  }
}

TEST(WhichWayIsUp, AStraightWalkThatSeesNothingOfTheGroundIsRefused) {
  EXPECT_THAT(OutcomesOf({.has_facades = false}), Each("refused"));
}

TEST(WhichWayIsUp, ACameraThatLooksAroundIsRarelyUpsideDown) {
  EXPECT_THAT(OutcomesOf({.swing_rad = 1.0, .has_facades = false}), Each("right"));
}

TEST(WhichWayIsUp, TheUserMaySayIt) {
  const WalkOptions walk = {.has_facades = false, .held = All(PictureUp::kRight)};
  EXPECT_THAT(OutcomesOf(walk, {.up = UpSource::kRight}), Each("right"));
  EXPECT_THAT(OutcomesOf(walk, {.up = UpSource::kLeft}), Each("wrong"));
}

TEST(WhichWayIsUp, OrientationsOfPhotosTell) {
  const WalkOptions walk = {.has_facades = false, .held = TopOrLeft};
  const ImageOrientations orientations = ExifOf(walk);
  EXPECT_THAT(OutcomesOf(walk, {}, orientations), Each("right"));
  EXPECT_THAT(OutcomesOf(walk, {.up = UpSource::kPhotos}, orientations), Each("right"));
  EXPECT_THAT(OutcomesOf(walk, {.up = UpSource::kPhotos}), Each("refused"));
}

TEST(WhichWayIsUp, GravityOfThePhotosTells) {
  for (const PictureUp up :
       {PictureUp::kTop, PictureUp::kLeft, PictureUp::kRight, PictureUp::kBottom}) {
    EXPECT_THAT(OutcomesOf({.has_facades = false, .feels_gravity = true, .held = All(up)}),
                Each("right"));
  }
}

TEST(WhichWayIsUp, ADroneThatLooksDownIsRightOnABentFlight) {
  EXPECT_THAT(OutcomesOf({.bend_rad = 1.2, .pitch_rad = -1.5, .has_facades = false}),
              Each("right"));
}

TEST(WhichWayIsUp, TheReportSaysHowThePhotosWereHeld) {
  const Walk walk = MakeWalk({.held = TopOrLeft});
  const UpReport up = Georegister(walk.reconstruction, walk.positions, {}).up;
  EXPECT_THAT(up.num_images, ::testing::ElementsAre(14, 13, 0, 0, 0));
  EXPECT_THAT(up.source, HasSubstr("ground"));
  EXPECT_GT(up.odds, 20.0);
}

TEST(WhichWayIsUp, NoneOfASweepOfWalksIsWrong) {
  int num_right = 0, num_walks = 0;
  for (const double bend_rad : {0.0, 0.3, 0.8}) {
    for (const double pitch_rad : {-0.3, -1.5}) {
      for (const PictureUp up : {PictureUp::kTop, PictureUp::kLeft, PictureUp::kBottom}) {
        WalkOptions walk = {.bend_rad = bend_rad, .num_photos = 15, .pitch_rad = pitch_rad};
        walk.held = [up](int i) { return i % 4 == 0 ? PictureUp::kTop : up; };
        walk.seed = ++num_walks;
        const bool has_exif = num_walks % 2 == 0;
        const std::string outcome =
            OutcomeOf(walk, {}, has_exif ? ExifOf(walk) : ImageOrientations());
        EXPECT_THAT(outcome, ::testing::AnyOf("right", "refused"))
            << "bend " << bend_rad << ", pitch " << pitch_rad << ", held " << static_cast<int>(up)
            << ", EXIF " << has_exif;
        num_right += outcome == "right";
      }
    }
  }
  EXPECT_GE(num_right, num_walks / 3);
}

TEST(WhichWayIsUp, AMirroredWalkWithABendIsRefused) {
  EXPECT_THAT(OutcomesOf({.bend_rad = 0.8, .is_mirrored = true}), Each("refused as mirrored"));
}

// Upside down, the mirror image of a photo in portrait format is in portrait format again, so only
// the ground speaks against it.
TEST(WhichWayIsUp, AMirroredWalkInPortraitFormatIsSaidToLookMirrored) {
  const Walk walk = MakeWalk({.bend_rad = 0.8, .is_mirrored = true, .held = All(PictureUp::kLeft)});
  EXPECT_THAT(Georegister(walk.reconstruction, walk.positions, {}).up.source,
              HasSubstr("a mirrored model, held upright, would be"));
}

TEST(WhichWayIsUp, PositionsOnALineTellNothingOfMirrors) {
  EXPECT_THAT(OutcomesOf({.is_mirrored = true}), Each(Ne("refused as mirrored")));
  EXPECT_THAT(OutcomesOf({.held = All(PictureUp::kBottom)}), Each(Ne("refused as mirrored")));
}

}  // namespace
}  // namespace cairn
