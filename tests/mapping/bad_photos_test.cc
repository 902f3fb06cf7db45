// `cairn map` up to the publication, on folders as people have them: what it corrects or leaves out
// with a line that says so, and what it refuses with a figure.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <regex>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/file_bytes.h"
#include "core/images/gray_image.h"
#include "core/images/reduce_image.h"
#include "mapping/photo_scene.h"
#include "mapping/session/map_photos.h"
#include "support/temp_dir.h"
#include "support/test_data.h"

namespace cairn {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::PhotoScene;
using testing::Shot;
using testing::Walk;

constexpr const char* kFountain = "facades_strecha/fountain-P11";

class BadPhotos : public ::testing::Test {
 protected:
  MappedPhotos Map(const std::vector<Shot>& shots) const { return Map(PhotoScene(7), shots); }
  MappedPhotos Map(const PhotoScene& scene, const std::vector<Shot>& shots) const {
    testing::WriteFolder(scene, shots, dir_.path() / "photos");
    return MapFolder();
  }
  MappedPhotos MapFolder(const std::string& positions_path = "") const {
    MapPhotosInput input;
    input.positions_path = positions_path;
    input.paths = {dir_.File("photos")};
    input.num_threads = 2;
    MappingOptions options;
    options.sift.max_features = 1000;
    return MapPhotos(input, options, {});
  }

  // Maps the fountain's 11 photos after `edit(index, photo, &keeps_exif)`, with their true
  // positions.
  MappedPhotos MapFountain(
      const std::function<GrayImage(int, const GrayImage&, bool*)>& edit) const {
    const std::filesystem::path fountain = testing::TestDataDir() / kFountain;
    std::filesystem::create_directories(dir_.path() / "photos");
    testing::ExifContent exif;
    exif.focal_35mm = 32;
    for (int i = 0; i < 11; ++i) {
      GrayImage image = ReduceByArea(
          ReadGrayImage((fountain / "images" / fmt::format("{:04}.jpg", i)).string()), 768 * 512);
      image.full.reset();
      bool keeps_exif = true;
      const std::vector<uint8_t> png = EncodePng(edit(i, image, &keeps_exif));
      testing::WriteBytes(
          dir_.path() / "photos" / fmt::format("{:04}.png", i),
          keeps_exif ? testing::PngWithExifBlock(png, testing::ExifBlock(exif)) : png);
    }
    const std::string table = ReadTextFile((fountain / "georef_exact.csv").string(), 1 << 20);
    std::ofstream(dir_.File("positions.csv")) << std::regex_replace(
        std::regex_replace(table, std::regex("[.]jpg"), ".png"), std::regex(",0[.]01\n"), ",0.5\n");
    return MapFolder(dir_.File("positions.csv"));
  }

  std::string RefusalOf(const std::vector<Shot>& shots) const {
    return RefusalOf(PhotoScene(7), shots);
  }
  std::string RefusalOf(const PhotoScene& scene, const std::vector<Shot>& shots) const {
    try {
      Map(scene, shots);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kBadInput);
      return error.what();
    }
    return "";
  }

  testing::TempDir dir_;
};

std::map<std::string, Shot> ByName(const std::vector<Shot>& shots) {
  std::map<std::string, Shot> by_name;
  for (const Shot& shot : shots) {
    by_name[shot.name] = shot;
  }
  return by_name;
}

// The largest distances of cameras from the truth: as the map stands on Earth, and after the
// similarity that fits best.
struct CameraErrors {
  double on_earth_m = 0.0, within_m = 0.0, turned_rad = 0.0;
};

CameraErrors ErrorsOf(const MappedPhotos& mapped, const std::vector<Shot>& shots) {
  const std::map<std::string, Shot> truth = ByName(shots);
  const Rigid3d enu_from_ecef = EcefFromEnu(PhotoScene::Origin()).Inverse();
  const auto num_images = static_cast<Eigen::Index>(mapped.model.images.size());
  Eigen::Matrix3Xd found(3, num_images), wanted(3, num_images);
  CameraErrors errors;
  for (Eigen::Index i = 0; i < num_images; ++i) {
    const ReconImage& image = mapped.model.images[static_cast<size_t>(i)];
    const Rigid3d in_ecef = CamFromTarget(image.cam_from_world, mapped.ecef_from_world);
    const Rigid3d true_cam = PhotoScene::CamFromEnu(truth.at(image.name));
    found.col(i) = enu_from_ecef * in_ecef.Inverse().translation;
    wanted.col(i) = true_cam.Inverse().translation;
    errors.on_earth_m = std::max(errors.on_earth_m, (found.col(i) - wanted.col(i)).norm());
    errors.turned_rad = std::max(
        errors.turned_rad, RotationAngleRad(in_ecef.rotation, (true_cam * enu_from_ecef).rotation));
  }
  const Eigen::Matrix4d fit = Eigen::umeyama(found, wanted, true);
  errors.within_m =
      (((fit.topLeftCorner<3, 3>() * found).colwise() + fit.topRightCorner<3, 1>()) - wanted)
          .colwise()
          .norm()
          .maxCoeff();
  return errors;
}

// Positions along a line leave the pitch of the cameras to what people do with cameras in hands.
void ExpectRight(const MappedPhotos& mapped, const std::vector<Shot>& shots) {
  const CameraErrors errors = ErrorsOf(mapped, shots);
  EXPECT_LT(errors.on_earth_m, 3.0);
  EXPECT_LT(errors.within_m, 0.1);
  EXPECT_LT(errors.turned_rad, 0.35);
}

// A part of an image whose sides are `crop` times shorter. `across` and `down` say where it is: 0
// is the left or upper edge, 0.5 the middle, 1 the right or lower edge.
GrayImage PartOf(const GrayImage& image, double crop, double across, double down) {
  GrayImage part =
      BlankImage(std::lround(image.width_px / crop), std::lround(image.height_px / crop));
  const int left = static_cast<int>(across * (image.width_px - part.width_px));
  const int top = static_cast<int>(down * (image.height_px - part.height_px));
  for (int y = 0; y < part.height_px; ++y) {
    std::copy_n(image.pixels.begin() + (top + y) * image.width_px + left, part.width_px,
                part.pixels.begin() + y * part.width_px);
  }
  return part;
}

// A flight. Its heights are those of GPS, 3 m off each, but its cameras say which way is up. Level
// ground leaves open a part of the focal length, and so the height above it.
void ExpectFlown(const MappedPhotos& mapped, const std::vector<Shot>& shots) {
  const CameraErrors errors = ErrorsOf(mapped, shots);
  EXPECT_LT(errors.on_earth_m, 3.0);
  EXPECT_LT(errors.within_m, 0.3);
  EXPECT_LT(errors.turned_rad, 0.07);
  EXPECT_EQ(mapped.georegistration.up.num_images[static_cast<size_t>(PictureUp::kBack)],
            mapped.num_mapped);
}

void ExpectMapped(const MappedPhotos& mapped, int least) {
  EXPECT_GE(mapped.num_mapped, least);
  for (const LeftOutPhoto& photo : mapped.left_out) {
    EXPECT_FALSE(photo.reason.empty()) << photo.name;
    if (mapped.num_mapped < least) {
      ADD_FAILURE() << photo.name << ": " << photo.reason;
    }
  }
}

void ExpectAtTheirPositions(const MappedPhotos& mapped, double max_error_m) {
  for (size_t i = 0; i < mapped.center_of_photo.size(); ++i) {
    ASSERT_TRUE(mapped.center_of_photo[i] && mapped.position_of_photo[i]);
    EXPECT_LT((*mapped.center_of_photo[i] - *mapped.position_of_photo[i]).norm(), max_error_m) << i;
  }
}

std::string ReasonFor(const MappedPhotos& mapped, const std::string& name) {
  for (const LeftOutPhoto& photo : mapped.left_out) {
    if (photo.name == name) {
      return photo.reason;
    }
  }
  return "";
}

TEST_F(BadPhotos, GoodOnesAreMapped) {
  const std::vector<Shot> shots = Walk(9);
  const MappedPhotos mapped = Map(shots);
  ExpectMapped(mapped, 9);
  ExpectRight(mapped, shots);
}

TEST_F(BadPhotos, AHundredMetersOffForSomeAreOutvoted) {
  std::vector<Shot> shots = Walk(11);
  shots[3].gps_error_m = {100.0, 0.0, 0.0};
  shots[8].gps_error_m = {-70.0, -70.0, 0.0};
  // The photos of the second wall grow in two parts, one of which has three photos with one of the
  // two positions.
  for (const uint64_t seed : {7, 11}) {
    const MappedPhotos mapped = Map(PhotoScene(seed), shots);
    ExpectMapped(mapped, 11);
    EXPECT_THAT(mapped.notes,
                ::testing::Contains(HasSubstr("2 positions disagree and do not count")));
    ExpectRight(mapped, shots);
  }
}

// A receiver that found its place only after four photos.
TEST_F(BadPhotos, AHundredMetersOffForTheFirstAreOutvoted) {
  std::vector<Shot> shots = Walk(11);
  for (int i = 0; i < 4; ++i) {
    shots[i].gps_error_m = {60.0, 80.0, 0.0};
  }
  const MappedPhotos mapped = Map(shots);
  ExpectMapped(mapped, 11);
  EXPECT_THAT(mapped.notes,
              ::testing::Contains(HasSubstr("4 positions disagree and do not count")));
  ExpectRight(mapped, shots);
}

TEST_F(BadPhotos, PortraitAndLandscapeMixed) {
  std::vector<Shot> shots = Walk(9);
  for (size_t i = 0; i < shots.size(); i += 2) {
    shots[i].roll_rad = 0.5 * kPi;
    shots[i].exif.orientation = 6;
  }
  const MappedPhotos mapped = Map(shots);
  ExpectMapped(mapped, 9);
  ExpectRight(mapped, shots);
}

// Narrow pictures of one wall: pairs have two stories, and the parts that grow share few points.
TEST_F(BadPhotos, ZoomedAndOfSeveralCameras) {
  std::vector<Shot> shots = Walk(10);
  for (size_t i = 1; i < shots.size(); i += 3) {
    shots[i].focal_px *= 1.5;
  }
  shots[2].width_px = shots[5].width_px = shots[6].width_px = 240;
  for (uint64_t seed = 1; seed <= 7; ++seed) {
    const MappedPhotos mapped = Map(PhotoScene(seed), shots);
    EXPECT_GE(mapped.cameras.size(), 3u);
    ExpectMapped(mapped, 9);
    ExpectRight(mapped, shots);
  }
}

// A program cropped every second photo and kept its EXIF, whose focal length is then 1.3 times too
// short. Without a correction, three photos stay out and two of the others are 2 m off.
TEST_F(BadPhotos, CroppedWithTheFocalLengthOfTheWholePicture) {
  CAIRN_SKIP_WITHOUT_DATA(kFountain);
  const MappedPhotos mapped = MapFountain([](int i, const GrayImage& image, bool*) {
    return i % 2 == 0 ? image : PartOf(image, 1.3, 0.5, 0.5);
  });
  ExpectMapped(mapped, 11);
  EXPECT_THAT(mapped.notes, ::testing::Contains(HasSubstr("EXIF of 5 photos contradicts")));
  ExpectAtTheirPositions(mapped, 0.1);
  ASSERT_EQ(mapped.cameras.size(), 6u);
  for (const CameraReport& camera : mapped.cameras) {
    const double factor = camera.num_photos == 1 ? 1.3 : 1.0;
    EXPECT_EQ(camera.source, FocalSource::kExif);
    EXPECT_NEAR(camera.camera.focal_px() / camera.focal_before_px, factor, 0.05);
  }
  EXPECT_THAT(mapped.stages, ::testing::Contains(::testing::Field(&StageCost::name, "EXIF check")));
}

// People cut out what they like. With the principal point in the middle of the part, the photos
// stand up to 3 m off.
TEST_F(BadPhotos, CroppedAnywhere) {
  CAIRN_SKIP_WITHOUT_DATA(kFountain);
  for (const bool has_exif : {true, false}) {
    const MappedPhotos mapped = MapFountain([&](int i, const GrayImage& image, bool* keeps_exif) {
      *keeps_exif = i % 4 != 1 || has_exif;
      return i % 4 != 1 ? image : PartOf(image, 1.4, i == 5 ? 0.9 : 0.1, i == 1 ? 0.8 : 0.2);
    });
    ExpectMapped(mapped, 11);
    ExpectAtTheirPositions(mapped, 0.15);
    EXPECT_THAT(mapped.notes, ::testing::Contains(HasSubstr("3 photos are parts")));
  }
}

// A program reduced some photos and kept their EXIF.
TEST_F(BadPhotos, EditedSize) {
  std::vector<Shot> shots = Walk(9);
  for (size_t i = 1; i < shots.size(); i += 2) {
    shots[i].width_px = 240;
    shots[i].height_px = 180;
    shots[i].focal_px *= 0.75;
  }
  const MappedPhotos mapped = Map(shots);
  ExpectMapped(mapped, 9);
  ExpectRight(mapped, shots);
}

TEST_F(BadPhotos, BlurredAndBlankOnesAreLeftOutWithAReason) {
  std::vector<Shot> shots = Walk(9);
  shots[4].blur_px = 40.0;
  const MappedPhotos mapped = Map(shots);
  ExpectMapped(mapped, 8);
  EXPECT_THAT(ReasonFor(mapped, shots[4].name), HasSubstr("blurred"));
  ExpectRight(mapped, shots);
}

TEST_F(BadPhotos, NightAndDay) {
  std::vector<Shot> shots = Walk(9);
  for (size_t i = 0; i < shots.size(); i += 3) {
    shots[i].gain = 0.25;
    shots[i].noise = 4.0;
  }
  const MappedPhotos mapped = Map(shots);
  ExpectMapped(mapped, 6);
  ExpectRight(mapped, shots);
}

// Each has a place of its own.
TEST_F(BadPhotos, OfTwoPlacesBecomeTwoPlacedParts) {
  std::vector<Shot> shots = Walk(7);
  std::vector<Shot> others = Walk(6, 300.0);
  for (Shot& shot : others) {
    shot.name = "other" + shot.name;
  }
  testing::WriteFolder(PhotoScene(8, 1.5, 300.0), others, dir_.path() / "photos");
  const MappedPhotos mapped = Map(shots);
  shots.insert(shots.end(), others.begin(), others.end());
  ExpectMapped(mapped, 13);
  EXPECT_EQ(mapped.segments.size(), 2u);
  EXPECT_LT(ErrorsOf(mapped, shots).on_earth_m, 5.0);
}

TEST_F(BadPhotos, TurningOnTheSpotIsRefused) {
  std::vector<Shot> shots = Walk(9);
  for (size_t i = 0; i < shots.size(); ++i) {
    shots[i].x_in_enu = {0.0, 0.0, 1.6};
    shots[i].yaw_rad = 0.1 * (static_cast<double>(i) - 4.0);
  }
  EXPECT_THAT(RefusalOf(shots), HasSubstr("turning on the spot"));
}

TEST_F(BadPhotos, ATurnWithinAWalkHarmsNothing) {
  std::vector<Shot> shots = Walk(8);
  for (int i = 0; i < 4; ++i) {
    Shot turn = shots[3];
    turn.name = "turn" + std::to_string(i) + ".png";
    turn.yaw_rad = 0.1 + 0.1 * i;
    shots.push_back(turn);
  }
  const MappedPhotos mapped = Map(shots);
  ExpectMapped(mapped, 8);
  ExpectRight(mapped, shots);
}

TEST_F(BadPhotos, AllPortrait) {
  std::vector<Shot> shots = Walk(9);
  for (Shot& shot : shots) {
    shot.x_in_enu.x() *= 0.7;  // A narrower picture needs more photos.
    shot.roll_rad = 0.5 * kPi;
    shot.exif.orientation = 6;
  }
  const MappedPhotos mapped = Map(shots);
  ExpectMapped(mapped, 9);
  ExpectRight(mapped, shots);
}

// A program turned the pixels, and the EXIF says that they are upright.
TEST_F(BadPhotos, AllPortraitWithTurnedPixels) {
  std::vector<Shot> shots = Walk(9);
  for (Shot& shot : shots) {
    shot.x_in_enu.x() *= 0.7;
    std::swap(shot.width_px, shot.height_px);
  }
  const MappedPhotos mapped = Map(shots);
  ExpectMapped(mapped, 9);
  ExpectRight(mapped, shots);
}

// Each pair of photos of a wall allows a second story, in which the camera turned beside it.
TEST_F(BadPhotos, OfAFlatWall) {
  std::vector<Shot> shots = Walk(9);
  for (Shot& shot : shots) {
    shot.x_in_enu.z() = 4.0;
  }
  const MappedPhotos mapped = Map(PhotoScene::FlatWall(7), shots);
  ExpectMapped(mapped, 9);
  ExpectRight(mapped, shots);
}

TEST_F(BadPhotos, LookingStraightDownAtAVillage) {
  const std::vector<Shot> shots = testing::Flight(3, 4, 40.0);
  const MappedPhotos mapped = Map(PhotoScene::Village(7, 25, 8.0), shots);
  ExpectMapped(mapped, 12);
  ExpectFlown(mapped, shots);
}

TEST_F(BadPhotos, LookingStraightDownAtLevelGroundInOneHeading) {
  const std::vector<Shot> shots = testing::Flight(3, 5, 40.0, /*is_fixed=*/true);
  const MappedPhotos mapped = Map(PhotoScene::Village(7, 0, 8.0), shots);
  ExpectMapped(mapped, 15);
  ExpectFlown(mapped, shots);
}

// The positions are then those of a mirrored flight. On a straight walk, nothing would tell.
TEST_F(BadPhotos, LatitudeAndLongitudeExchanged) {
  std::vector<Shot> shots = testing::Flight(3, 4, 40.0);
  for (Shot& shot : shots) {
    const Geodetic gps =
        GeodeticFromEcef(EcefFromEnu(PhotoScene::Origin()) * (shot.x_in_enu + shot.gps_error_m));
    shot.exif.lat_deg = gps.lon_deg();
    shot.exif.lon_deg = gps.lat_deg();
    shot.exif.altitude_m = gps.h_m;
    shot.exif.altitude_ref = 2;
    shot.exif.error_m = 1.5;
  }
  EXPECT_THAT(RefusalOf(PhotoScene::Village(7, 25, 8.0), shots),
              AllOf(HasSubstr("mirrored"), HasSubstr("latitude and longitude")));
}

TEST_F(BadPhotos, MostWithoutGps) {
  std::vector<Shot> shots = Walk(10);
  for (size_t i = 0; i < shots.size(); ++i) {
    shots[i].has_gps = i % 3 == 0;
  }
  const MappedPhotos mapped = Map(shots);
  ExpectMapped(mapped, 10);
  EXPECT_THAT(mapped.notes, ::testing::Contains(HasSubstr("6 of 10 photos have no position")));
  ExpectRight(mapped, shots);
}

}  // namespace
}  // namespace cairn
