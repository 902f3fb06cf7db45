// Which way is up: walks with a phone held in every way, straight and bent, with rough positions.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "ingest/place/georegister.h"
#include "ingest/simulated_walk.h"

namespace cairn {
namespace {

using testing::All;
using testing::DrawnWalk;
using testing::DrawWalk;
using ::testing::Each;
using testing::ExifOf;
using ::testing::HasSubstr;
using testing::MakeWalk;
using ::testing::Ne;
using testing::OutcomeOf;
using ::testing::StartsWith;
using testing::Walk;
using testing::WalkOptions;

// For each of three seeds.
std::vector<std::string> OutcomesOf(WalkOptions options, const GeoregisterOptions& georegister = {},
                                    const ImageOrientations& orientations = {}) {
  std::vector<std::string> outcomes;
  for (options.seed = 1; options.seed <= 3; ++options.seed) {
    outcomes.push_back(OutcomeOf(options, georegister, orientations));
  }
  return outcomes;
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
                Each(StartsWith("right")));
  }
}

TEST(WhichWayIsUp, AStraightWalkThatSeesNothingOfTheGroundIsRefused) {
  EXPECT_THAT(OutcomesOf({.has_facades = false}), Each("refused"));
}

TEST(WhichWayIsUp, TheGroundTellsUprightFromUpsideDown) {
  EXPECT_THAT(OutcomesOf({.swing_rad = 1.0}), Each("right"));
  EXPECT_THAT(OutcomesOf({.swing_rad = 1.0, .has_facades = false}), Each("right"));
}

TEST(WhichWayIsUp, TheUserMaySayIt) {
  const WalkOptions walk = {.has_facades = false, .held = All(PictureUp::kRight)};
  EXPECT_THAT(OutcomesOf(walk, {.up = UpSource::kRight}), Each("right"));
  EXPECT_THAT(OutcomesOf(walk, {.up = UpSource::kLeft}), Each("wrong"));
}

TEST(WhichWayIsUp, TheUsersWordAgainstAllElseIsNoted) {
  const Walk walk = MakeWalk({.swing_rad = 1.0});
  const auto source = [&](UpSource up) {
    return Georegister(walk.reconstruction, walk.positions, {.up = up}).up.source;
  };
  EXPECT_THAT(source(UpSource::kBottom), HasSubstr("without --up, another up would be"));
  EXPECT_THAT(source(UpSource::kLeft), HasSubstr("without --up, another up would be"));
  EXPECT_THAT(source(UpSource::kTop), ::testing::Not(HasSubstr("without --up")));
}

TEST(WhichWayIsUp, OrientationsOfPhotosTell) {
  const WalkOptions walk = {.has_facades = false, .held = TopOrLeft};
  const ImageOrientations orientations = ExifOf(walk);
  EXPECT_THAT(OutcomesOf(walk, {}, orientations), Each("right"));
  EXPECT_THAT(OutcomesOf(walk, {.up = UpSource::kPhotos}, orientations), Each("right"));
  EXPECT_THAT(OutcomesOf(walk, {.up = UpSource::kPhotos}), Each("refused"));
}

// A phone's walk as people take it: straight ahead, GPS off by 5 m, orientations in the photos.
// CAIRN_WALKS=1:50 draws 50 walks of each kind.
TEST(WhichWayIsUp, StraightWalksWithOrientationsAreNotRefused) {
  uint64_t first_seed = 1, num_walks = 1;
  if (const char* range = std::getenv("CAIRN_WALKS")) {
    ASSERT_EQ(std::sscanf(range, "%" SCNu64 ":%" SCNu64, &first_seed, &num_walks), 2);
  }
  for (const double pitch_rad : {0.0, -0.3}) {
    for (const PictureUp up : {PictureUp::kTop, PictureUp::kLeft, PictureUp::kRight}) {
      WalkOptions walk = {
          .length_m = 81.0, .gps_sigma_m = 5.0, .pitch_rad = pitch_rad, .held = All(up)};
      for (walk.seed = first_seed; walk.seed < first_seed + num_walks; ++walk.seed) {
        EXPECT_THAT(OutcomeOf(walk, {}, ExifOf(walk)), StartsWith("right"))
            << "pitch " << pitch_rad << ", held " << static_cast<int>(up) << ", seed " << walk.seed;
      }
    }
  }
}

TEST(WhichWayIsUp, GravityOfThePhotosTells) {
  for (const PictureUp up :
       {PictureUp::kTop, PictureUp::kLeft, PictureUp::kRight, PictureUp::kBottom}) {
    EXPECT_THAT(OutcomesOf({.has_facades = false, .feels_gravity = true, .held = All(up)}),
                Each("right"));
  }
}

// COLMAP 4 writes the EXIF orientation as gravity. Programs turn pixels and leave the orientation.
TEST(WhichWayIsUp, GravityThatIsAnAxisOfThePictureIsItsExifOrientation) {
  const std::pair<int, Eigen::Vector3d> axes[] = {{1, Eigen::Vector3d::UnitY()},
                                                  {3, -Eigen::Vector3d::UnitY()},
                                                  {6, Eigen::Vector3d::UnitX()},
                                                  {8, -Eigen::Vector3d::UnitX()}};
  for (const auto& [orientation, down_in_cam] : axes) {
    const Walk walk = MakeWalk({.bend_rad = 0.8});
    const ImageOrientations orientations(walk.reconstruction.images.size(), orientation);
    const UpReport by_exif = Georegister(walk.reconstruction, walk.positions, {}, orientations).up;
    Walk by_colmap = walk;
    for (ReconImage& image : by_colmap.reconstruction.images) {
      image.down_in_cam = down_in_cam;
    }
    const UpReport up = Georegister(by_colmap.reconstruction, by_colmap.positions, {}).up;
    EXPECT_EQ(up.source, by_exif.source) << orientation;
    EXPECT_EQ(up.num_images, by_exif.num_images);
    EXPECT_EQ(up.num_images[0], 27) << "the walk is held upright whatever the orientation says";
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

TEST(WhichWayIsUp, ASteepFlightOnALineIsRefused) {
  for (const PictureUp up : {PictureUp::kTop, PictureUp::kLeft}) {
    const WalkOptions over_ground = {.pitch_rad = -1.5, .held = All(up)};
    EXPECT_THAT(OutcomesOf(over_ground), Each("refused"));
    EXPECT_THAT(OutcomesOf(over_ground, {}, ExifOf(over_ground)), Each("refused"));
  }
}

// Viewers turn pixels, and phones whose rotation is locked write 1.
TEST(WhichWayIsUp, OrientationsThatAreAllOneDoNotLayAWalkOnItsSide) {
  for (const PictureUp up : {PictureUp::kLeft, PictureUp::kRight, PictureUp::kBottom}) {
    for (const double pitch_rad : {0.0, -0.3}) {
      const WalkOptions walk = {.pitch_rad = pitch_rad, .held = All(up)};
      EXPECT_THAT(OutcomesOf(walk, {}, ImageOrientations(walk.num_photos, 1)), Each(Ne("wrong")))
          << "held " << static_cast<int>(up) << ", pitch " << pitch_rad;
    }
  }
}

TEST(WhichWayIsUp, NoneOfAGridOfWalksIsWrong) {
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
        EXPECT_THAT(outcome, ::testing::AnyOf(StartsWith("right"), "refused"))
            << "bend " << bend_rad << ", pitch " << pitch_rad << ", held " << static_cast<int>(up)
            << ", EXIF " << has_exif;
        num_right += outcome.starts_with("right");
      }
    }
  }
  EXPECT_GE(num_right, num_walks / 3);
}

// CAIRN_WALKS=1000:800 draws 800 walks from seed 1000 on, instead of the few of every run.
TEST(WhichWayIsUp, NoneOfASweepOfWalksIsWrong) {
  uint64_t first_seed = 5001, num_walks = 20;
  if (const char* range = std::getenv("CAIRN_WALKS")) {
    ASSERT_EQ(std::sscanf(range, "%" SCNu64 ":%" SCNu64, &first_seed, &num_walks), 2);
  }
  std::map<std::string, uint64_t> counts;
  for (uint64_t seed = first_seed; seed < first_seed + num_walks; ++seed) {
    const DrawnWalk drawn = DrawWalk(seed);
    const std::string outcome = OutcomeOf(drawn.options, {}, drawn.orientations);
    EXPECT_EQ(outcome.find("wrong"), std::string::npos) << "seed " << seed << ": " << drawn.name;
    ++counts[outcome];
  }
  for (const auto& [outcome, count] : counts) {
    std::printf("%s: %" PRIu64 "\n", outcome.c_str(), count);
  }
  EXPECT_GE(counts["right"], num_walks / 2);
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
