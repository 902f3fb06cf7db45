#include "mapping/photos/group_cameras.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "core/error.h"

namespace cairn {
namespace {

PhotoLens LensOf(int width_px, int height_px, uint64_t kind = 0, double focal_35mm = 0.0) {
  PhotoLens photo;
  photo.width_px = width_px;
  photo.height_px = height_px;
  photo.has_exif = kind != 0;
  photo.exif.camera_kind = kind;
  if (focal_35mm > 0.0) {
    photo.exif.focal_35mm = focal_35mm;
  }
  return photo;
}

TEST(GroupCameras, PhotosOfOnePhoneShareACamera) {
  const CameraGroups groups =
      GroupCameras({LensOf(4000, 3000, 7, 26.0), LensOf(4000, 3000, 7, 26.0)}, {});
  ASSERT_EQ(groups.cameras.size(), 1u);
  EXPECT_EQ(groups.cameras[0].source, FocalSource::kExif);
  EXPECT_NEAR(groups.cameras[0].camera.focal_px(), 26.0 / 36.0 * 4000.0, 1e-9);
}

TEST(GroupCameras, ZoomKindAndSizeTellCamerasApart) {
  const CameraGroups groups =
      GroupCameras({LensOf(4000, 3000, 7, 26.0), LensOf(4000, 3000, 7, 52.0),
                    LensOf(4000, 3000, 8, 26.0), LensOf(3000, 4000, 7, 26.0)},
                   {});
  EXPECT_EQ(groups.camera_of_photo, (std::vector<int>{0, 1, 2, 3}));
}

TEST(GroupCameras, FramesOfARecordingShareACamera) {
  const CameraGroups groups =
      GroupCameras({LensOf(1226, 370), LensOf(1226, 370), LensOf(1226, 370)}, {});
  ASSERT_EQ(groups.cameras.size(), 1u);
  EXPECT_EQ(groups.cameras[0].source, FocalSource::kGuess);
}

TEST(GroupCameras, PhotosFromManyHandsShareNone) {
  const CameraGroups groups = GroupCameras(
      {LensOf(1000, 700), LensOf(1000, 700), LensOf(800, 600), LensOf(700, 900), LensOf(640, 480)},
      {});
  EXPECT_EQ(groups.cameras.size(), 5u);
}

TEST(GroupCameras, ParametersOfAnotherSizeOfThePictureAreRefused) {
  const PhotoLens photo = LensOf(1024, 768, 7, 36.0);  // 1024 px.
  for (const double factor : {0.5, 1.875, 3.9375}) {
    const Camera known(CameraModel::kSimplePinhole, 1024, 768,
                       {factor * 1000.0, factor * 512.0, factor * 384.0});
    try {
      GroupCameras({photo}, {known});
      ADD_FAILURE() << factor;
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), ErrorCode::kBadInput);
      EXPECT_NE(std::string(e.what()).find("times as large"), std::string::npos) << e.what();
    }
    EXPECT_NO_THROW(GroupCameras({LensOf(1024, 768)}, {known})) << "without EXIF, nothing tells";
  }
}

TEST(GroupCameras, AKnownCameraCountsBeforeTheExifWhichIsSaid) {
  const Camera known(CameraModel::kSimplePinhole, 1024, 768, {1500.0, 512.0, 384.0});
  const CameraGroups groups =
      GroupCameras({LensOf(1024, 768, 7, 36.0), LensOf(1024, 768, 7, 36.0)}, {known});
  EXPECT_EQ(groups.cameras[0].source, FocalSource::kCalibration);
  ASSERT_EQ(groups.notes.size(), 1u);
  EXPECT_NE(groups.notes[0].find("1.46 times that of the EXIF of 2 photos"), std::string::npos)
      << groups.notes[0];
  EXPECT_TRUE(GroupCameras({LensOf(1024, 768, 7, 36.0)},
                           {Camera(CameraModel::kSimplePinhole, 1024, 768, {1030.0, 512.0, 384.0})})
                  .notes.empty());
}

TEST(GroupCameras, AKnownCameraServesItsSizeAndSmallerCopies) {
  const Camera known(CameraModel::kPinhole, 2000, 1000, {1500.0, 1510.0, 1010.0, 505.0});
  const CameraGroups groups =
      GroupCameras({LensOf(2000, 1000), LensOf(1000, 500), LensOf(1000, 1000)}, {known});
  ASSERT_EQ(groups.cameras.size(), 3u);
  EXPECT_EQ(groups.cameras[0].camera.params(), known.params());
  EXPECT_EQ(groups.cameras[1].source, FocalSource::kCalibration);
  EXPECT_EQ(groups.cameras[1].camera.params(), (std::vector<double>{750.0, 755.0, 505.0, 252.5}));
  EXPECT_EQ(groups.cameras[2].source, FocalSource::kGuess);
  EXPECT_EQ(groups.notes.size(), 1u);
}

TEST(GroupCameras, TheFocalLengthOfACroppedPhotoIsAGuess) {
  PhotoLens cropped = LensOf(3000, 3000, 7, 26.0);
  cropped.exif.original_width_px = 4000;
  cropped.exif.original_height_px = 3000;
  const CameraGroups groups = GroupCameras({cropped, cropped}, {});
  EXPECT_EQ(groups.cameras.size(), 2u);
  EXPECT_EQ(groups.cameras[0].source, FocalSource::kGuess);
  EXPECT_EQ(groups.notes.size(), 1u);
}

TEST(GroupCameras, ASmallerPhotoMayBeCropped) {
  const CameraGroups groups =
      GroupCameras({LensOf(4000, 3000, 7, 26.0), LensOf(3000, 4000, 7, 26.0),
                    LensOf(3200, 2400, 7, 26.0), LensOf(800, 600, 8, 26.0)},
                   {});
  ASSERT_EQ(groups.cameras.size(), 4u);
  EXPECT_FALSE(groups.cameras[0].may_be_cropped);
  EXPECT_FALSE(groups.cameras[1].may_be_cropped);
  EXPECT_TRUE(groups.cameras[2].may_be_cropped);
  EXPECT_FALSE(groups.cameras[3].may_be_cropped);
  EXPECT_EQ(groups.cameras[2].source, FocalSource::kExif);
  EXPECT_GT(groups.cameras[2].focal.log_sigma, 0.5 * std::log(1.25));
}

TEST(GroupCameras, EachPhotoOfASmallerSizeMayBeAnotherPart) {
  const CameraGroups groups = GroupCameras(
      {LensOf(4000, 3000, 7, 26.0), LensOf(2000, 1500, 7, 26.0), LensOf(2000, 1500, 7, 26.0)}, {});
  ASSERT_EQ(groups.cameras.size(), 3u);
  EXPECT_TRUE(groups.cameras[2].may_be_cropped);
}

TEST(GroupCameras, TheFocalLengthOfAReducedPhotoCounts) {
  PhotoLens reduced = LensOf(1024, 768, 7, 26.0);
  reduced.exif.original_width_px = 4000;
  reduced.exif.original_height_px = 3000;
  const CameraGroups groups = GroupCameras({reduced}, {});
  EXPECT_EQ(groups.cameras[0].source, FocalSource::kExif);
}

}  // namespace
}  // namespace cairn
