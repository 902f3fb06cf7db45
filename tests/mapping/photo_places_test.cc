// Positions of a table beside those in the EXIF of the same photos.
#include "mapping/session/photo_places.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/error.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

using ::testing::HasSubstr;

constexpr int kNumGpsPhotos = 4;
constexpr double kLatDeg = 55.698, kLonDeg = 13.195, kStepDeg = 1e-4;

class PhotoPlacesTest : public ::testing::Test {
 protected:
  PhotoPlacesTest() {
    for (int i = 0; i < kNumGpsPhotos; ++i) {
      MappingPhoto photo;
      photo.name = std::to_string(i) + ".jpg";
      photo.gps = Geodetic::FromDegrees(kLatDeg + i * kStepDeg, kLonDeg, 37.0);
      folder_.set.photos.push_back(photo);
      folder_.orientation_of_photo.emplace_back();
    }
  }

  // The places by a table whose rows begin at this position and go north.
  PhotoPlaces Find(double lat_deg, double lon_deg) {
    input_.positions_path = (dir_.path() / "table.csv").string();
    std::ofstream table(input_.positions_path);
    table << "image,lat_deg,lon_deg,h_m\n";
    table.precision(9);
    for (int i = 0; i < kNumGpsPhotos; ++i) {
      table << i << ".jpg," << lat_deg + i * kStepDeg << "," << lon_deg << ",37\n";
    }
    table.close();
    return FindPhotoPlaces(input_, &folder_, &notes_);
  }

  testing::TempDir dir_;
  MapPhotosInput input_;
  PhotoFolder folder_;
  std::vector<std::string> notes_;
};

TEST_F(PhotoPlacesTest, ATableReplacesExif) {
  const PhotoPlaces places = Find(kLatDeg + 1e-3, kLonDeg);
  ASSERT_EQ(places.positions.size(), static_cast<size_t>(kNumGpsPhotos));
  EXPECT_NEAR(places.positions[0]->position.lat_deg(), kLatDeg + 1e-3, 1e-9);
  EXPECT_NEAR(folder_.set.photos[0].gps->lat_deg(), kLatDeg + 1e-3, 1e-9);
  EXPECT_TRUE(notes_.empty());
}

TEST_F(PhotoPlacesTest, SaysHowManyPositionsAreOfNoPhoto) {
  folder_.set.photos.pop_back();
  folder_.orientation_of_photo.pop_back();
  Find(kLatDeg, kLonDeg);
  ASSERT_EQ(notes_.size(), 1u);
  EXPECT_EQ(notes_[0], "1 of 4 positions in the table are of no photo: '3.jpg'");
}

TEST_F(PhotoPlacesTest, FindsThePhotosThatTheTableNames) {
  const std::filesystem::path photos = dir_.path() / "photos";
  std::filesystem::create_directories(photos);
  for (const char* name : {"1.JPG", "1 (1).jpg", "9.jpg"}) {
    std::ofstream(photos / name) << "";
  }
  input_.paths = {photos.string()};
  EXPECT_TRUE(NamesInTable(input_).empty());
  Find(kLatDeg, kLonDeg);
  EXPECT_EQ(NamesInTable(input_), std::set<std::string>{"1.JPG"});
}

TEST_F(PhotoPlacesTest, SaysHowManyPositionsOfExifAreDoubtful) {
  folder_.num_without_hemisphere = 4;
  folder_.num_void_positions = 1;
  FindPhotoPlaces(input_, &folder_, &notes_);
  ASSERT_EQ(notes_.size(), 2u);
  EXPECT_THAT(notes_[0], HasSubstr("4 photos have a position whose hemisphere is not stated"));
  EXPECT_THAT(notes_[1], HasSubstr("1 photos have a position that the receiver marked as void"));
  notes_.clear();
  Find(kLatDeg, kLonDeg);
  EXPECT_TRUE(notes_.empty());
}

TEST_F(PhotoPlacesTest, RefusesLatitudesThatAreLongitudesByExif) {
  try {
    Find(kLonDeg, kLatDeg);
    FAIL() << "not refused";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadInput);
    EXPECT_THAT(error.what(), HasSubstr("latitude and longitude have changed places"));
    EXPECT_THAT(error.what(), HasSubstr("table.csv"));
  }
}

TEST_F(PhotoPlacesTest, SaysThatATableIsOfAnotherTown) {
  Find(kLatDeg + 1.0, kLonDeg);
  ASSERT_EQ(notes_.size(), 1u);
  EXPECT_THAT(notes_[0], HasSubstr("111.3 km from those in the EXIF"));
}

}  // namespace
}  // namespace cairn
