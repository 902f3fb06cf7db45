#include "http/json/request_photos.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/focal_length.h"
#include "core/geoid.h"
#include "support/exif_bytes.h"

namespace cairn {
namespace {

using testing::ExifBlock;
using testing::ExifContent;

// A JPEG of 640 x 480 without pixels: headers are all that ReadPhotos reads.
std::vector<uint8_t> PhotoOf(const ExifContent& exif) {
  return testing::JpegWithExifBlock(
      {0xff, 0xd8, 0xff, 0xc0, 0, 11, 8, 0x01, 0xe0, 0x02, 0x80, 1,    1,   0x11, 0,  //
       0xff, 0xda, 0,    8,    1, 1,  0, 0,    63,   0,    0x55, 0xff, 0xd9},
      ExifBlock(exif));
}

ExifContent InLund() {
  ExifContent exif;
  exif.orientation = 6;
  exif.lat_deg = 55.7;
  exif.lon_deg = 13.2;
  exif.altitude_m = 40.0;
  exif.error_m = 7.5;
  return exif;
}

LocalizeRequest RequestOf(const ExifContent& exif, int width_px, int height_px) {
  LocalizeRequest request;
  request.query.camera =
      Camera(CameraModel::kSimplePinhole, width_px, height_px, {500.0, 320.0, 240.0});
  request.images.push_back({.bytes = PhotoOf(exif), .format = ""});
  return request;
}

TEST(ReadPhotos, TakesThePositionOfTheExif) {
  LocalizeRequest request = RequestOf(InLund(), 480, 640);
  ReadPhotos(true, &request);
  ASSERT_TRUE(request.query.prior.has_value());
  const PositionPrior& prior = *request.query.prior;
  EXPECT_EQ(prior.source, PriorSource::kPhoto);
  EXPECT_NEAR(prior.position.lat_deg(), 55.7, 1e-6);
  EXPECT_NEAR(prior.position.lon_deg(), 13.2, 1e-6);
  const Geodetic& at = prior.position;
  EXPECT_NEAR(at.h_m, 40.0 + Geoid::Egm96().HeightM(at.lat_rad, at.lon_rad), 1e-6);
  EXPECT_NEAR(prior.accuracy_m, 7.5, 1e-6);
  EXPECT_FALSE(prior.height_sigma_m.has_value());
  EXPECT_EQ(request.images[0].orientation, 6);
}

TEST(ReadPhotos, AnErrorThatIsNotStatedIs25M) {
  ExifContent exif = InLund();
  exif.error_m.reset();
  LocalizeRequest request = RequestOf(exif, 640, 480);
  ReadPhotos(true, &request);
  ASSERT_TRUE(request.query.prior.has_value());
  EXPECT_EQ(request.query.prior->accuracy_m, 25.0);
  EXPECT_EQ(request.images[0].orientation, 1);  // The size is that of the stored pixels.
}

TEST(ReadPhotos, ThePriorOfTheRequestStays) {
  LocalizeRequest request = RequestOf(InLund(), 640, 480);
  request.query.prior = PositionPrior{Geodetic::FromDegrees(1.0, 2.0, 3.0), 15.0, std::nullopt};
  ReadPhotos(true, &request);
  EXPECT_EQ(request.query.prior->source, PriorSource::kClient);
  EXPECT_EQ(request.query.prior->accuracy_m, 15.0);
}

TEST(ReadPhotos, TheRequestAndTheOperatorMayForbidIt) {
  LocalizeRequest refused = RequestOf(InLund(), 480, 640);
  refused.exif_prior = false;
  ReadPhotos(true, &refused);
  EXPECT_FALSE(refused.query.prior.has_value());
  EXPECT_EQ(refused.images[0].orientation, 6);  // The EXIF still turns the photo.
  LocalizeRequest request = RequestOf(InLund(), 480, 640);
  ReadPhotos(false, &request);
  EXPECT_FALSE(request.query.prior.has_value());
}

TEST(ReadPhotos, ACameraOfWhichOnlyTheSizeIsStatedHasTheFocalLengthOfTheExif) {
  ExifContent exif = InLund();
  exif.focal_35mm = 27;
  LocalizeRequest request = RequestOf(exif, 480, 640);
  request.query.camera = CameraOfUnknownFocal(480, 640);
  request.query.focal = FocalPrior{.with_distortion = true};
  request.picture.reset();
  ReadPhotos(false, &request);
  EXPECT_NEAR(request.query.camera.focal_px(), 27.0 / 36.0 * 640.0, 1e-6);
  EXPECT_EQ(request.query.camera.width_px(), 480);
  ASSERT_TRUE(request.query.focal.has_value());
  EXPECT_LT(request.query.focal->log_sigma, FocalPrior().log_sigma);
  EXPECT_FALSE(request.query.focal->with_distortion);
}

TEST(ReadPhotos, TheFocalLengthOfTheRequestStays) {
  ExifContent exif = InLund();
  exif.focal_35mm = 27;
  LocalizeRequest request = RequestOf(exif, 480, 640);
  request.query.focal = FocalPrior();  // Unknown, but the other parameters are known.
  ReadPhotos(true, &request);
  EXPECT_EQ(request.query.camera.focal_px(), 500.0);
  EXPECT_EQ(request.query.focal->log_sigma, FocalPrior().log_sigma);
}

TEST(ReadPhotos, WithoutAFocalLengthTheCameraStaysUnknown) {
  LocalizeRequest request = RequestOf(InLund(), 480, 640);
  request.query.camera = CameraOfUnknownFocal(480, 640);
  request.query.focal = FocalPrior{.with_distortion = true};
  ReadPhotos(true, &request);
  EXPECT_EQ(request.query.camera.focal_px(), CameraOfUnknownFocal(480, 640).focal_px());
  EXPECT_TRUE(request.query.focal->with_distortion);
}

TEST(ReadPhotos, SettledOrientationsStay) {
  LocalizeRequest request = RequestOf(InLund(), 480, 640);
  request.picture.reset();
  ReadPhotos(true, &request);
  EXPECT_EQ(request.images[0].orientation, 1);
  EXPECT_TRUE(request.query.prior.has_value());
}

TEST(ReadPhotos, WithoutAPositionThereIsNoPrior) {
  ExifContent none = InLund();
  none.lat_deg.reset();
  ExifContent zero = InLund();
  zero.lat_deg = zero.lon_deg = 0.0;
  ExifContent lost = InLund();
  lost.error_m = 200.0;
  EXPECT_TRUE(PriorOfPhoto(ReadExif(PhotoOf(lost))).has_value());
  ExifInfo very_lost = ReadExif(PhotoOf(lost));
  very_lost.gps_error_m = 150e3;
  EXPECT_FALSE(PriorOfPhoto(very_lost).has_value());
  for (const ExifContent& exif : {none, zero}) {
    LocalizeRequest request = RequestOf(exif, 640, 480);
    ReadPhotos(true, &request);
    EXPECT_FALSE(request.query.prior.has_value());
  }
  LocalizeRequest raw = RequestOf(InLund(), 640, 480);
  raw.images[0].bytes = std::vector<uint8_t>(640 * 480);
  ReadPhotos(true, &raw);
  EXPECT_FALSE(raw.query.prior.has_value());
}

}  // namespace
}  // namespace cairn
