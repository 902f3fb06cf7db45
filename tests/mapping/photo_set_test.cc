#include "mapping/photo_set.h"

#include <gtest/gtest.h>

#include "core/error.h"

namespace cairn {
namespace {

PhotoSet TwoPhotos() {
  PhotoSet set;
  set.cameras.emplace_back();
  for (const char* name : {"a.jpg", "b.jpg"}) {
    MappingPhoto& photo = set.photos.emplace_back();
    photo.name = name;
    photo.keypoints.resize(2);
    photo.descriptors = ByteDescriptorMatrix(2, 128);
  }
  return set;
}

TEST(PhotoSet, AcceptsPhotosWithAndWithoutFeatures) {
  PhotoSet set = TwoPhotos();
  EXPECT_NO_THROW(set.Validate());
  set.photos[1].keypoints.clear();
  set.photos[1].descriptors = {};
  EXPECT_NO_THROW(set.Validate());
}

TEST(PhotoSet, RefusesWhatLaterStagesCouldNotRead) {
  PhotoSet set = TwoPhotos();
  set.photos[1].name = "a.jpg";
  EXPECT_THROW(set.Validate(), Error);
  set = TwoPhotos();
  set.photos[1].camera_idx = 1;
  EXPECT_THROW(set.Validate(), Error);
  set = TwoPhotos();
  set.photos[0].keypoints.pop_back();
  EXPECT_THROW(set.Validate(), Error);
  set = TwoPhotos();
  set.photos[0].descriptors = ByteDescriptorMatrix(2, 64);
  EXPECT_THROW(set.Validate(), Error);
}

}  // namespace
}  // namespace cairn
