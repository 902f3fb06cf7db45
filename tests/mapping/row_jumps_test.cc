#include "mapping/session/row_jumps.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "support/street_photos.h"

namespace cairn {
namespace {

constexpr int kNumPhotos = 40;
constexpr double kEastRad = 1.6e-5;  // 57 m at this latitude.

// A walk north with a photo each 3 m, which show nothing.
PhotoSet WalkNorth(int num_photos = kNumPhotos) {
  PhotoSet set;
  set.cameras.push_back({Camera(CameraModel::kPinhole, 640, 480, {400.0, 400.0, 320.0, 240.0}),
                         {},
                         FocalSource::kCalibration});
  for (int i = 0; i < num_photos; ++i) {
    MappingPhoto photo;
    photo.name = std::to_string(100 + i) + ".jpg";
    photo.gps = Geodetic::FromDegrees(55.698 + 2.7e-5 * i, 13.195, 37.0);
    photo.gps_accuracy_m = 2.0;
    set.photos.push_back(photo);
  }
  return set;
}

std::vector<int> WithoutPosition(const PhotoSet& set) {
  std::vector<int> photos;
  for (size_t i = 0; i < set.photos.size(); ++i) {
    if (!set.photos[i].gps) {
      EXPECT_FALSE(set.photos[i].gps_accuracy_m);
      photos.push_back(static_cast<int>(i));
    }
  }
  return photos;
}

std::vector<int> Dropped(PhotoSet set) {
  DropJumps(5.0, {}, &set);
  return WithoutPosition(set);
}

PhotoSet WithEast(PhotoSet set, const std::vector<int>& photos) {
  for (const int photo : photos) {
    set.photos[photo].gps->lon_rad += kEastRad;
  }
  return set;
}

std::vector<int> Range(int begin, int end) {
  std::vector<int> range;
  for (int i = begin; i < end; ++i) {
    range.push_back(i);
  }
  return range;
}

TEST(RowJumps, SinglePositionsThatAreFarOff) {
  const std::vector<int> off = {0, 7, 8, 15, 39};
  EXPECT_EQ(Dropped(WithEast(WalkNorth(), off)), off);
}

TEST(RowJumps, ARunThatJumpsAwayAndBack) {
  EXPECT_EQ(Dropped(WithEast(WalkNorth(), Range(15, 24))), Range(15, 24));
}

TEST(RowJumps, AWalkThatGoesOnElsewhereKeepsItsPositions) {
  EXPECT_EQ(Dropped(WithEast(WalkNorth(), Range(25, kNumPhotos))), Range(0, 0));
}

TEST(RowJumps, AWalkOfItsOwnBetweenTwoPartsKeepsItsPositions) {
  EXPECT_EQ(Dropped(WithEast(WalkNorth(), Range(13, 26))), Range(0, 0));
}

TEST(RowJumps, AReceiverThatHadNotFoundItsPlace) {
  PhotoSet set = WalkNorth();
  for (int i = 0; i < 5; ++i) {
    set.photos[i].gps = Geodetic::FromDegrees(55.698, 13.197, 37.0);
  }
  EXPECT_EQ(Dropped(set), Range(0, 5));
}

TEST(RowJumps, PhotosInNoOrderKeepTheirPositions) {
  PhotoSet set = WalkNorth(20);
  for (int i = 0; i < 20; ++i) {
    set.photos[i].gps->lat_rad += 1e-5 * ((7 * i) % 20);
  }
  EXPECT_EQ(Dropped(set), Range(0, 0));
}

TEST(RowJumps, PhotosWithoutPositionsOrWithFew) {
  EXPECT_EQ(Dropped(WalkNorth(0)), Range(0, 0));
  PhotoSet set = WithEast(WalkNorth(5), {2});
  for (const int photo : {0, 1, 3, 4}) {
    set.photos[photo].gps_accuracy_m.reset();
  }
  EXPECT_EQ(Dropped(set), Range(0, 0));
}

PhotoSet Street(uint64_t seed) {
  testing::StreetWorldOptions options;
  options.length_m = 30.0;
  options.keyframe_step_m = 2.0;
  options.num_landmarks = 700;
  options.seed = seed;
  const Reconstruction street = testing::StreetWorld(options).Reconstruct();
  PhotoSet set = testing::PhotosOf(street);
  testing::AddNoisyPositions(street, 0.5, 1.0, seed, &set);
  return set;
}

TEST(RowJumps, ARunThatShowsTheSameAsTheNextIsMisplaced) {
  const PhotoSet street = Street(1);
  EXPECT_EQ(Dropped(WithEast(street, Range(0, 6))), Range(0, 6));
  const int count = static_cast<int>(street.photos.size());
  EXPECT_EQ(Dropped(WithEast(street, Range(4, count))), Range(0, 4));
  EXPECT_EQ(Dropped(street), Range(0, 0));
}

// The largest run is the misplaced one, but most photos are near the others.
TEST(RowJumps, TheRunsOfMostPhotosAreBelieved) {
  PhotoSet set = Street(1);
  ASSERT_GE(set.photos.size(), 14u);
  set = WithEast(std::move(set), Range(0, 5));
  set.photos.resize(14);
  set.photos.erase(set.photos.begin() + 9);  // A gap that is no step.
  for (size_t i = 9; i < set.photos.size(); ++i) {
    set.photos[i].gps->lat_rad += 2e-6;  // 13 m.
  }
  const std::vector<int> dropped = Dropped(set);
  EXPECT_EQ(std::vector<int>(dropped.begin(), dropped.begin() + 5), Range(0, 5));
  EXPECT_EQ(dropped.size(), 9u);  // One of the runs of four keeps its positions.
}

TEST(RowJumps, TwoPlacesInOneFolderKeepTheirPositions) {
  PhotoSet set = Street(1);
  const int num_first = static_cast<int>(set.photos.size());
  for (MappingPhoto& photo : Street(77).photos) {
    photo.name = "there/" + photo.name;
    set.photos.push_back(std::move(photo));
  }
  EXPECT_EQ(Dropped(WithEast(set, Range(num_first, 2 * num_first))), Range(0, 0));
}

// Heights above the ellipsoid among heights above the sea.
TEST(RowJumps, HeightsThatJumpAreNone) {
  PhotoSet set = Street(1);
  const int count = static_cast<int>(set.photos.size());
  for (int i = 0; i < 5; ++i) {
    set.photos[i].gps->h_m += 45.0;
  }
  set.photos[count - 3].gps->h_m -= 45.0;
  DropJumps(5.0, {}, &set);
  EXPECT_EQ(WithoutPosition(set), Range(0, 0));
  for (int i = 0; i < count; ++i) {
    EXPECT_EQ(set.photos[i].gps_has_height, i >= 5 && i != count - 3) << i;
  }
}

}  // namespace
}  // namespace cairn
