#include "core/images/image_header.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/error.h"
#include "core/file_bytes.h"
#include "core/images/exif.h"
#include "core/images/gray_image.h"
#include "support/temp_dir.h"
#include "support/test_data.h"

namespace cairn {
namespace {

using ::testing::HasSubstr;
using Bytes = std::vector<uint8_t>;

// A PNG that claims to be 100,000 x 100,000 and holds nothing.
Bytes PngBomb() {
  return {0x89, 'P',  'N',  'G', '\r', '\n', 0x1a, '\n',  //
          0,    0,    0,    13,  'I',  'H',  'D',  'R',  0, 1, 0x86, 0xa0, 0,
          1,    0x86, 0xa0, 8,   0,    0,    0,    0,    0, 0, 0,    0,  //
          0,    0,    0,    0,   'I',  'E',  'N',  'D',  0, 0, 0,    0};
}

// The segments of a 640 x 480 JPEG around one byte of pixels.
Bytes JpegSkeleton() {
  return {0xff, 0xd8,                                                      //
          0xff, 0xc0, 0, 11, 8, 0x01, 0xe0, 0x02, 0x80, 1, 1,    0x11, 0,  //
          0xff, 0xda, 0, 8,  1, 1,    0,    0,    63,   0, 0x55, 0xff, 0xd9};
}

Bytes Pgm(int width, int height) {
  const std::string header =
      "P5 # made up\n" + std::to_string(width) + " " + std::to_string(height) + "\n255\n";
  Bytes bytes(header.begin(), header.end());
  for (int i = 0; i < width * height; ++i) {
    bytes.push_back(static_cast<uint8_t>(i));
  }
  return bytes;
}

TEST(ImageHeader, ReadsSizesWithoutPixels) {
  EXPECT_EQ(ParseImageHeader(JpegSkeleton()).width_px, 640);
  EXPECT_EQ(ParseImageHeader(JpegSkeleton()).height_px, 480);
  EXPECT_EQ(ParseImageHeader(PngBomb()).width_px, 100'000);
  EXPECT_EQ(ParseImageHeader(Pgm(7, 3)).width_px, 7);
  EXPECT_EQ(ParseImageHeader(Pgm(7, 3)).height_px, 3);
}

TEST(ImageHeader, EveryTruncationIsAnError) {
  Bytes jpeg = JpegSkeleton();
  jpeg.resize(jpeg.size() - 3);  // Up to the pixels, of which the header says nothing.
  for (const Bytes& whole : {jpeg, PngBomb(), Pgm(4, 4)}) {
    EXPECT_NO_THROW(ParseImageHeader(whole));
    for (size_t size = 0; size < whole.size(); ++size) {
      const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
      EXPECT_THROW(ParseImageHeader(cut), Error) << "cut to " << size;
    }
  }
}

TEST(ImageHeader, FlippedBytesNeverReadOutside) {
  for (const Bytes& whole : {JpegSkeleton(), PngBomb(), Pgm(4, 4)}) {
    for (size_t i = 0; i < whole.size(); ++i) {
      for (const int mask : {0x01, 0x80, 0xff}) {
        Bytes flipped = whole;
        flipped[i] = static_cast<uint8_t>(flipped[i] ^ mask);
        try {
          const ImageHeader header = ParseImageHeader(flipped);
          EXPECT_GE(header.width_px, 1);
          EXPECT_GE(header.height_px, 1);
        } catch (const Error& e) {
          EXPECT_EQ(e.code(), ErrorCode::kBadInput);
        }
      }
    }
  }
}

TEST(ImageHeader, RefusesOtherFormats) {
  const std::string gif = "GIF89a.........";
  EXPECT_THROW(ParseImageHeader(Bytes(gif.begin(), gif.end())), Error);
}

TEST(ImageHeader, SaysThatAFileIsAVideoOrEmpty) {
  const auto refusal_of = [](const std::string& text) -> std::string {
    try {
      ParseImageHeader(Bytes(text.begin(), text.end()));
    } catch (const Error& e) {
      return e.what();
    }
    return "no error";
  };
  for (const char* brand : {"qt  ", "isom", "mp42", "avc1", "3gp5"}) {
    EXPECT_THAT(refusal_of(std::string("___ ftyp") + brand + "...."), HasSubstr("is a video"));
  }
  EXPECT_THAT(refusal_of("___ ftypheic...."), HasSubstr("HEIC or AVIF"));
  EXPECT_THAT(refusal_of(""), HasSubstr("is empty"));
}

TEST(DecodeGrayImage, DecodesPgm) {
  const GrayImage image = DecodeGrayImage(Pgm(5, 4));
  EXPECT_EQ(image.width_px, 5);
  EXPECT_EQ(image.height_px, 4);
  ASSERT_EQ(image.pixels.size(), 20u);
  EXPECT_EQ(image.pixels[7], 7);
}

TEST(DecodeGrayImage, RefusesABombByItsHeader) {
  try {
    DecodeGrayImage(PngBomb());
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::kBadInput);
    EXPECT_THAT(e.what(), ::testing::HasSubstr("100000 x 100000"));
  }
}

TEST(DecodeGrayImage, RefusesAnImageAboveTheLimit) {
  EXPECT_NO_THROW(DecodeGrayImage(Pgm(10, 10), {.max_pixels = 100}));
  EXPECT_THROW(DecodeGrayImage(Pgm(10, 10), {.max_pixels = 99}), Error);
}

TEST(DecodeGrayImage, RefusesAHeaderWithoutAnImage) {
  EXPECT_THROW(DecodeGrayImage(JpegSkeleton()), Error);
}

TEST(ReadGrayImage, NamesTheFile) {
  const testing::TempDir dir;
  try {
    ReadGrayImage(dir.File("none.png"));
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::kNotFound);
    EXPECT_THAT(e.what(), ::testing::HasSubstr("none.png"));
  }
}

TEST(ReadGrayImage, RefusesATruncatedPhoto) {
  CAIRN_SKIP_WITHOUT_DATA("street_lund/images/01.jpg");
  Bytes bytes =
      ReadFileBytes((testing::TestDataDir() / "street_lund/images/01.jpg").string(), 1 << 24);
  EXPECT_EQ(DecodeGrayImage(bytes).width_px, 1024);
  bytes.resize(bytes.size() / 2);
  EXPECT_THROW(DecodeGrayImage(bytes), Error);
}

TEST(ReadExif, ReadsPlaceAndFocalLength) {
  CAIRN_SKIP_WITHOUT_DATA("street_lund/images/01.jpg");
  const ExifInfo exif = ReadExif(
      ReadFileBytes((testing::TestDataDir() / "street_lund/images/01.jpg").string(), 1 << 24));
  ASSERT_TRUE(exif.gps.has_value());
  EXPECT_NEAR(exif.gps->lat_deg(), 55.6981666666667, 1e-9);
  EXPECT_NEAR(exif.gps->lon_deg(), 13.1953888888889, 1e-9);
  EXPECT_TRUE(exif.has_altitude);
  EXPECT_NEAR(exif.gps->h_m, 37.0, 1e-9);
  EXPECT_EQ(exif.focal_35mm, 35.0);
  EXPECT_EQ(exif.width_px, 1024);
  EXPECT_EQ(exif.height_px, 768);
}

// A JPEG skeleton with the EXIF of a phone: `altitude_ref` and the orientation.
Bytes JpegWithExif(uint8_t altitude_ref, uint8_t orientation) {
  const Bytes tiff = {'I',  'I',  42, 0, 8, 0, 0, 0,                         // Header, IFD0 at 8.
                      2,    0,                                               // Two entries.
                      0x12, 0x01, 3,  0, 1, 0, 0, 0, orientation,  0, 0, 0,  // Orientation.
                      0x25, 0x88, 4,  0, 1, 0, 0, 0, 38,           0, 0, 0,  // GPS IFD at 38.
                      0,    0,    0,  0,                                     // No IFD1.
                      6,    0,                                               // Six entries.
                      1,    0,    2,  0, 2, 0, 0, 0, 'N',          0, 0, 0,  // Latitude is north,
                      2,    0,    5,  0, 3, 0, 0, 0, 116,          0, 0, 0,  // at 116.
                      3,    0,    2,  0, 2, 0, 0, 0, 'E',          0, 0, 0,  // Longitude is east,
                      4,    0,    5,  0, 3, 0, 0, 0, 116,          0, 0, 0,  // the same numbers.
                      5,    0,    1,  0, 1, 0, 0, 0, altitude_ref, 0, 0, 0,  //
                      6,    0,    5,  0, 1, 0, 0, 0, 140,          0, 0, 0,  // Altitude at 140.
                      0,    0,    0,  0,                                     //
                      10,   0,    0,  0, 1, 0, 0, 0, 30,           0, 0, 0, 1, 0, 0, 0,
                      0,    0,    0,  0, 1, 0, 0, 0,   // 10 deg 30'.
                      25,   0,    0,  0, 2, 0, 0, 0};  // 12.5 m.
  Bytes app1 = {0xff, 0xe1, 0, static_cast<uint8_t>(2 + 6 + tiff.size()), 'E', 'x', 'i', 'f', 0, 0};
  app1.insert(app1.end(), tiff.begin(), tiff.end());
  Bytes jpeg = JpegSkeleton();
  jpeg.insert(jpeg.begin() + 2, app1.begin(), app1.end());
  return jpeg;
}

TEST(ReadExif, AltitudesAreAboveSeaLevelUnlessTheySayTheEllipsoid) {
  const auto read = [](uint8_t altitude_ref) { return ReadExif(JpegWithExif(altitude_ref, 1)); };
  ASSERT_TRUE(read(0).gps.has_value());
  EXPECT_NEAR(read(0).gps->lat_deg(), 10.5, 1e-9);
  EXPECT_EQ(read(0).gps->h_m, 12.5);
  EXPECT_EQ(read(0).height_reference, HeightReference::kMeanSeaLevel);
  EXPECT_EQ(read(1).gps->h_m, -12.5);
  EXPECT_EQ(read(1).height_reference, HeightReference::kMeanSeaLevel);
  EXPECT_EQ(read(2).gps->h_m, 12.5);
  EXPECT_EQ(read(2).height_reference, HeightReference::kEllipsoid);
  EXPECT_EQ(read(3).gps->h_m, -12.5);
  EXPECT_EQ(read(3).height_reference, HeightReference::kEllipsoid);
}

TEST(ReadExif, ReadsTheOrientation) {
  EXPECT_EQ(ReadExif(JpegWithExif(0, 6)).orientation, 6);
  EXPECT_EQ(ReadExif(JpegWithExif(0, 0)).orientation, 1);
  EXPECT_EQ(ReadExif(JpegWithExif(0, 9)).orientation, 1);
  EXPECT_EQ(ReadExif(JpegSkeleton()).orientation, 1);
}

TEST(ReadExif, AnImageWithoutExifHasJustASize) {
  const ExifInfo exif = ReadExif(JpegSkeleton());
  EXPECT_FALSE(exif.gps.has_value());
  EXPECT_FALSE(exif.focal_35mm.has_value());
  EXPECT_EQ(exif.width_px, 640);
}

TEST(ReadExif, DamagedExifNeverCrashes) {
  CAIRN_SKIP_WITHOUT_DATA("street_lund/images/01.jpg");
  const Bytes whole =
      ReadFileBytes((testing::TestDataDir() / "street_lund/images/01.jpg").string(), 1 << 24);
  const ImageHeader header = ParseImageHeader(whole);
  ASSERT_FALSE(header.exif.empty());
  const size_t begin = static_cast<size_t>(header.exif.data() - whole.data());
  for (size_t i = 0; i < std::min<size_t>(header.exif.size(), 600); ++i) {
    Bytes flipped = whole;
    flipped[begin + i] ^= 0xff;
    const ExifInfo exif = ReadExif(flipped);
    EXPECT_EQ(exif.width_px, 1024);
    EXPECT_NO_THROW(ValidateGeodetic(exif.gps.value_or(Geodetic{}), "exif"));
  }
}

}  // namespace
}  // namespace cairn
