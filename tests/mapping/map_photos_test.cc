// `cairn map` up to the publication, on real photos.
#include "mapping/session/map_photos.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "core/csv.h"
#include "core/error.h"
#include "core/file_bytes.h"
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

// Distances of the camera centers from the laser scan, after the similarity that fits best.
Eigen::VectorXd CenterErrors(const Reconstruction& model) {
  std::map<std::string, Eigen::Vector3d> truth;
  const std::string text = ReadTextFile((FountainFolder() / "truth.csv").string(), 1 << 20);
  CsvReader reader(text);
  while (reader.Next()) {
    if (reader.cells().size() == 11 && reader.Number(8)) {
      truth[reader.cells()[0]] = {*reader.Number(8), *reader.Number(9), *reader.Number(10)};
    }
  }
  Eigen::Matrix3Xd found(3, model.images.size()), wanted(3, model.images.size());
  for (size_t i = 0; i < model.images.size(); ++i) {
    found.col(i) = model.images[i].cam_from_world.Inverse().translation;
    wanted.col(i) = truth.at(model.images[i].name);
  }
  const Eigen::Matrix4d fit = Eigen::umeyama(found, wanted, /*with_scaling=*/true);
  return (((fit.topLeftCorner<3, 3>() * found).colwise() + fit.topRightCorner<3, 1>()) - wanted)
      .colwise()
      .norm();
}

// COLMAP 3.8 on the same photos, with 4,000 features: 2.4 mm in the mean. The bar is 1.25 times.
TEST(MapPhotos, IsAsNearTheLaserScanAsColmap) {
  CAIRN_SKIP_WITHOUT_DATA(kFountain);
  const MappedPhotos mapped = MapPhotos(FountainInput(), FewFeatures(2500), {});
  ASSERT_EQ(mapped.num_mapped, 11);
  EXPECT_TRUE(mapped.left_out.empty());
  const Eigen::VectorXd errors = CenterErrors(mapped.model);
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
  const auto from_work = [](const MappedPhotos& mapped, const std::string& stage) {
    return std::any_of(mapped.stages.begin(), mapped.stages.end(),
                       [&](const StageCost& cost) { return cost.name == stage && cost.from_work; });
  };
  EXPECT_FALSE(from_work(first, "photos"));
  options.two_views.min_inliers = 25;
  const MappedPhotos second = MapPhotos(input, options, {});
  EXPECT_TRUE(from_work(second, "photos"));
  EXPECT_FALSE(from_work(second, "matching"));
  EXPECT_FALSE(from_work(second, "growth"));
  const MappedPhotos third = MapPhotos(input, options, {});
  EXPECT_TRUE(from_work(third, "growth"));
  ASSERT_EQ(third.model.images.size(), second.model.images.size());
  for (size_t i = 0; i < third.model.images.size(); ++i) {
    EXPECT_EQ(third.model.images[i].cam_from_world.ToMatrix(),
              second.model.images[i].cam_from_world.ToMatrix());
  }
}

}  // namespace
}  // namespace cairn
