// `cairn map` up to the publication, on real photos.
#include "mapping/session/map_photos.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <map>

#include "core/csv.h"
#include "core/error.h"
#include "core/file_bytes.h"
#include "core/images/gray_image.h"
#include "ingest/colmap/colmap_model.h"
#include "support/temp_dir.h"
#include "support/test_data.h"

namespace cairn {
namespace {

constexpr const char* kFountain = "facades_strecha/fountain-P11";

std::filesystem::path FountainFolder() { return testing::TestDataDir() / kFountain; }

MapPhotosInput FountainInput() {
  MapPhotosInput input;
  input.paths = {(FountainFolder() / "images").string()};
  input.positions_path = (FountainFolder() / "gps_3m.csv").string();
  input.cameras = {Camera(CameraModel::kPinhole, 1536, 1024, {1379.74, 1382.08, 760.595, 503.655})};
  input.num_threads = 2;
  return input;
}

MappingOptions FewFeatures(int max_features) {
  MappingOptions options;
  options.sift.max_features = max_features;
  return options;
}

using PositionOfPhoto = std::map<std::string, Eigen::Vector3d>;

PositionOfPhoto CentersByName(const Reconstruction& model) {
  PositionOfPhoto centers;
  for (const ReconImage& image : model.images) {
    centers[image.name] = image.cam_from_world.Inverse().translation;
  }
  return centers;
}

// Distances of the centers from the truth, in its units, after the similarity that fits best.
Eigen::VectorXd CenterErrors(const PositionOfPhoto& centers, const PositionOfPhoto& truth) {
  Eigen::Matrix3Xd found(3, centers.size()), wanted(3, centers.size());
  Eigen::Index i = 0;
  for (const auto& [name, center] : centers) {
    found.col(i) = center;
    wanted.col(i++) = truth.at(name);
  }
  const Eigen::Matrix4d fit = Eigen::umeyama(found, wanted, /*with_scaling=*/true);
  return (((fit.topLeftCorner<3, 3>() * found).colwise() + fit.topRightCorner<3, 1>()) - wanted)
      .colwise()
      .norm();
}

PositionOfPhoto LaserScanOfTheFountain() {
  PositionOfPhoto truth;
  const std::string text = ReadTextFile((FountainFolder() / "truth.csv").string(), 1 << 20);
  CsvReader reader(text);
  while (reader.Next()) {
    if (reader.cells().size() == 11 && reader.Number(8)) {
      truth[reader.cells()[0]] = {*reader.Number(8), *reader.Number(9), *reader.Number(10)};
    }
  }
  return truth;
}

bool IsFromWork(const MappedPhotos& mapped, const std::string& stage) {
  return std::any_of(mapped.stages.begin(), mapped.stages.end(),
                     [&](const StageCost& cost) { return cost.name == stage && cost.from_work; });
}

// COLMAP 3.8 on the same photos, with 4,000 features: 2.4 mm in the mean. The bar is 1.25 times.
TEST(MapPhotos, IsAsNearTheLaserScanAsColmap) {
  CAIRN_SKIP_WITHOUT_DATA(kFountain);
  const MappedPhotos mapped = MapPhotos(FountainInput(), FewFeatures(2500), {});
  ASSERT_EQ(mapped.num_mapped, 11);
  EXPECT_TRUE(mapped.left_out.empty());
  const Eigen::VectorXd errors =
      CenterErrors(CentersByName(mapped.model), LaserScanOfTheFountain());
  EXPECT_LE(errors.mean(), 1.25 * 0.0024);
  EXPECT_LE(errors.maxCoeff(), 2.0 * 0.0038);
}

// A photo of another place and a second copy: the map is made without them, and each is named with
// its reason.
TEST(MapPhotos, NamesWhatItLeavesOut) {
  CAIRN_SKIP_WITHOUT_DATA(kFountain);
  const testing::TempDir dir;
  std::filesystem::create_directory(dir.path() / "photos");
  const auto link = [&](const std::filesystem::path& photo, const std::string& name) {
    std::filesystem::create_symlink(photo, dir.path() / "photos" / name);
  };
  for (const char* name : {"0003.jpg", "0004.jpg", "0005.jpg", "0006.jpg"}) {
    link(FountainFolder() / "images" / name, name);
  }
  link(FountainFolder() / "images" / "0004.jpg", "copy.jpg");
  link(testing::TestDataDir() / "facades_strecha/Herz-Jesus-P8/images/0003.jpg", "church.jpg");
  MapPhotosInput input = FountainInput();
  input.paths = {dir.File("photos")};
  input.positions_path = (FountainFolder() / "georef_exact.csv").string();
  const MappedPhotos mapped = MapPhotos(input, FewFeatures(1000), {});
  EXPECT_EQ(mapped.num_mapped, 4);
  ASSERT_EQ(mapped.left_out.size(), 2u);
  EXPECT_EQ(mapped.left_out[0].name, "church.jpg");
  EXPECT_EQ(mapped.left_out[0].reason, "no other photo shows enough of what it shows");
  EXPECT_EQ(mapped.left_out[1].reason, "is the same file as 0004.jpg");
}

// A second run with another option takes the photos from the work folder, but not what depends on
// the option.
TEST(MapPhotos, RunsAgainWhatAChangedOptionChanges) {
  CAIRN_SKIP_WITHOUT_DATA(kFountain);
  const testing::TempDir dir;
  MapPhotosInput input = FountainInput();
  input.work_dir = dir.File("w");
  MappingOptions options = FewFeatures(600);
  const MappedPhotos first = MapPhotos(input, options, {});
  EXPECT_FALSE(IsFromWork(first, "photos"));
  options.two_views.min_inliers = 25;
  const MappedPhotos second = MapPhotos(input, options, {});
  EXPECT_TRUE(IsFromWork(second, "photos"));
  EXPECT_FALSE(IsFromWork(second, "matching"));
  EXPECT_FALSE(IsFromWork(second, "growth"));
  const MappedPhotos third = MapPhotos(input, options, {});
  EXPECT_TRUE(IsFromWork(third, "growth"));
  ASSERT_EQ(third.model.images.size(), second.model.images.size());
  for (size_t i = 0; i < third.model.images.size(); ++i) {
    EXPECT_EQ(third.model.images[i].cam_from_world.ToMatrix(),
              second.model.images[i].cam_from_world.ToMatrix());
  }
}

constexpr const char* kDrive = "kitti_vo_2x51";

// The truth is a file of poses, one a line: the first three rows of world_from_cam.
PositionOfPhoto TruthOfTheDrive() {
  PositionOfPhoto truth;
  std::ifstream file(testing::TestDataDir() / kDrive / "KITTI_sequence_2/poses.txt");
  std::array<double, 12> rows;
  for (int i = 0; file >> rows[0]; ++i) {
    for (size_t k = 1; k < rows.size(); ++k) {
      file >> rows[k];
    }
    truth[fmt::format("{:06}.png", i)] = {rows[3], rows[7], rows[11]};
  }
  return truth;
}

// Twenty photos of a drive around a corner, which looks ahead, of an unknown camera whose focal
// length is 719 px and not the 1,055 px that are assumed. From there, segments are bent by meters.
TEST(MapPhotos, FindsTheFocalLengthOfADriveByGrowingAgain) {
  CAIRN_SKIP_WITHOUT_DATA(kDrive);
  const testing::TempDir dir;
  std::filesystem::create_directory(dir.path() / "photos");
  for (int i = 8; i < 28; ++i) {
    const std::string name = fmt::format("{:06}.png", i);
    std::filesystem::create_symlink(
        testing::TestDataDir() / kDrive / "KITTI_sequence_2/image_l" / name,
        dir.path() / "photos" / name);
  }
  MapPhotosInput input;
  input.paths = {dir.File("photos")};
  input.positions_path = (testing::TestDataDir() / kDrive / "georef_seq2.csv").string();
  input.work_dir = dir.File("w");
  input.num_threads = 2;
  const MappedPhotos first = MapPhotos(input, MappingOptions(), {});
  EXPECT_EQ(first.num_mapped, 20);
  EXPECT_NEAR(first.cameras.at(0).camera.focal_px(), 718.9, 0.04 * 718.9);
  EXPECT_LT(CenterErrors(CentersByName(first.model), TruthOfTheDrive()).maxCoeff(), 0.2);
  EXPECT_FALSE(IsFromWork(first, "matching again"));

  // As if the run was killed before its segments were kept.
  std::filesystem::remove(dir.path() / "w" / "segments");
  input.num_threads = 1;
  const MappedPhotos second = MapPhotos(input, MappingOptions(), {});
  EXPECT_TRUE(IsFromWork(second, "matching again"));
  EXPECT_FALSE(IsFromWork(second, "matching"));
  ASSERT_EQ(second.num_mapped, first.num_mapped);
  for (size_t i = 0; i < first.model.images.size(); ++i) {
    EXPECT_EQ(second.model.images[i].cam_from_world.ToMatrix(),
              first.model.images[i].cam_from_world.ToMatrix());
  }
}

// COLMAP's pose of 20.jpg is 56 m from its GPS, and 26 m above the street.
TEST(MapPhotosOfAStreet, AllAreInAndStandWhereColmapHasTheOthers) {
  constexpr const char* kStreet = "street_lund";
  CAIRN_SKIP_WITHOUT_DATA(kStreet);
  const std::filesystem::path folder = testing::TestDataDir() / kStreet;
  MapPhotosInput input;
  input.paths = {folder / "images"};
  input.num_threads = 2;
  const MappedPhotos mapped = MapPhotos(input, FewFeatures(2500), {});
  EXPECT_EQ(mapped.num_mapped, 29);
  PositionOfPhoto colmap;
  for (const ColmapImage& image : ReadColmapModel((folder / "colmap_model").string()).images) {
    colmap[image.name] = image.cam_from_world.Inverse().translation;
  }
  ASSERT_EQ(colmap.erase("20.jpg"), 1u);
  EXPECT_EQ(colmap.size(), 28u);
  EXPECT_LT(CenterErrors(colmap, CentersByName(mapped.model)).maxCoeff(), 1.0);  // Meters.
}

// Ten photos by ten people, without EXIF, each with a camera of its own. Nobody knows their
// positions, and these place nothing.
TEST(MapPhotosOfTourists, AreOneSegment) {
  constexpr const char* kPhotos = "sacre_coeur10/datasets/sacre_coeur/mapping";
  CAIRN_SKIP_WITHOUT_DATA(kPhotos);
  const testing::TempDir dir;
  std::ofstream positions(dir.File("positions.csv"));
  positions << "image,lat_deg,lon_deg,h_m\n";
  MapPhotosInput input;
  input.paths = {(testing::TestDataDir() / kPhotos).string()};
  for (const auto& photo : std::filesystem::directory_iterator(input.paths.front())) {
    positions << fmt::format("{},{},2.3431,120\n", photo.path().filename().string(),
                             48.8862 + 1e-5 * static_cast<double>(photo.file_size() % 5));
  }
  positions.close();
  input.positions_path = dir.File("positions.csv");
  input.keeps_unplaced = true;
  input.num_threads = 2;
  const MappedPhotos mapped = MapPhotos(input, FewFeatures(2500), {});
  ASSERT_EQ(mapped.unplaced.size(), 1u);
  EXPECT_EQ(mapped.unplaced[0].segment.photo_of_image.size(), 10u);
}

// Programs that edit photos leave them beside the originals: brighter, and without EXIF. An
// original and its copy were the strongest link of each other, and both waited for it.
TEST(MapPhotosOfAStreet, EditedCopiesKeepNoOriginalOut) {
  constexpr const char* kStreet = "street_lund/images";
  CAIRN_SKIP_WITHOUT_DATA(kStreet);
  const testing::TempDir dir;
  for (int i = 5; i <= 12; ++i) {
    const std::string name = fmt::format("{:02}", i);
    const std::filesystem::path photo = testing::TestDataDir() / kStreet / (name + ".jpg");
    std::filesystem::copy(photo, dir.path());
    if (i == 7 || i == 12) {
      GrayImage image = ReadGrayImage(photo.string());
      for (uint8_t& value : image.pixels) {
        value = static_cast<uint8_t>(std::min(255.0, 1.08 * value));
      }
      std::ofstream(dir.File(name + "-edited.pgm"), std::ios::binary)
          << fmt::format("P5\n{} {}\n255\n", image.width_px, image.height_px)
          << std::string(image.pixels.begin(), image.pixels.end());
    }
  }
  MapPhotosInput input;
  input.paths = {dir.path()};
  input.num_threads = 2;
  GeoregisterOptions upright;
  upright.up = UpSource::kTop;
  EXPECT_EQ(MapPhotos(input, {}, upright).num_mapped, 10);
}

}  // namespace
}  // namespace cairn
