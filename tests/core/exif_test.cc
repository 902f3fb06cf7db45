// Tests the EXIF reader on whole, damaged, truncated and hostile blocks.
#include "core/images/exif.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/images/image_header.h"
#include "core/images/tiff_directory.h"
#include "support/exif_bytes.h"

namespace cairn {
namespace {

using testing::ExifBlock;
using testing::ExifContent;
using testing::ExifEntry;
using testing::ExifWriter;
using testing::JpegWithExifBlock;
using testing::PngWithExifBlock;
using Bytes = std::vector<uint8_t>;

// The segments of a 640 x 480 JPEG around one byte of pixels.
Bytes Jpeg() {
  return {0xff, 0xd8,                                                      //
          0xff, 0xc0, 0, 11, 8, 0x01, 0xe0, 0x02, 0x80, 1, 1,    0x11, 0,  //
          0xff, 0xda, 0, 8,  1, 1,    0,    0,    63,   0, 0x55, 0xff, 0xd9};
}

// The header and the end of a 64 x 48 PNG.
Bytes Png() {
  return {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n',                                  //
          0,    0,   0,   13,  'I',  'H',  'D',  'R',  0, 0, 0, 64, 0, 0, 0, 48, 8, 0,  //
          0,    0,   0,   0,   0,    0,    0,                                           //
          0,    0,   0,   0,   'I',  'E',  'N',  'D',  0, 0, 0, 0};
}

// All that the reader knows.
ExifContent PhonePhoto(bool is_little_endian) {
  ExifContent content;
  content.is_little_endian = is_little_endian;
  content.orientation = 6;
  content.lat_deg = -33.856784;
  content.lon_deg = 151.215297;
  content.altitude_m = 12.5;
  content.error_m = 4.75;
  content.focal_35mm = 26;
  content.maker_note = Bytes(300, 0x12);
  content.has_thumbnail_directory = true;
  return content;
}

// A JPEG whose only metadata are these properties of an XMP.
ExifInfo ReadXmp(const std::string& properties) {
  const std::string packet =
      std::string("http://ns.adobe.com/xap/1.0/\0", 29) + "<rdf:Description " + properties + "/>";
  Bytes jpeg = Jpeg();
  Bytes app1 = {0xff, 0xe1, 0, static_cast<uint8_t>(2 + packet.size())};
  app1.insert(app1.end(), packet.begin(), packet.end());
  jpeg.insert(jpeg.begin() + 2, app1.begin(), app1.end());
  return ReadExif(jpeg);
}

ExifInfo ReadBlock(const Bytes& block) { return ReadExif(JpegWithExifBlock(Jpeg(), block)); }

void ExpectPhonePhoto(const ExifInfo& exif) {
  ASSERT_TRUE(exif.gps.has_value());
  EXPECT_NEAR(exif.gps->lat_deg(), -33.856784, 1e-7);
  EXPECT_NEAR(exif.gps->lon_deg(), 151.215297, 1e-7);
  EXPECT_NEAR(exif.gps->h_m, 12.5, 1e-9);
  EXPECT_TRUE(exif.has_altitude);
  EXPECT_NEAR(exif.gps_error_m.value_or(0.0), 4.75, 1e-6);
  EXPECT_EQ(exif.focal_35mm, 26.0);
  EXPECT_EQ(exif.orientation, 6);
}

// A value of a damaged block is either what a photo may have or missing.
void ExpectPlausible(const ExifInfo& exif) {
  EXPECT_GE(exif.orientation, 1);
  EXPECT_LE(exif.orientation, 8);
  EXPECT_NO_THROW(ValidateGeodetic(exif.gps.value_or(Geodetic{}), "exif"));
  EXPECT_GT(exif.focal_35mm.value_or(1.0), 0.0);
  EXPECT_GT(exif.gps_error_m.value_or(1.0), 0.0);
}

// A block whose EXIF directory is the second, at a place that both directories know.
Bytes BlockWith(const testing::ExifDirectory& more_first, const testing::ExifDirectory& exif) {
  const ExifWriter writer(true);
  testing::ExifDirectory first = more_first;
  first[0x8769] = writer.Long(0);
  first[0x8769] = writer.Long(8 + testing::DirectoryBytes(first));
  Bytes tiff = {'I', 'I', 42, 0, 8, 0, 0, 0};
  testing::PutDirectory(first, 0, writer, &tiff);
  testing::PutDirectory(exif, 0, writer, &tiff);
  return tiff;
}

TEST(Exif, SaysIfHemispheresAreMissing) {
  ExifContent content = PhonePhoto(true);
  EXPECT_FALSE(ReadBlock(ExifBlock(content)).gps_lacks_hemisphere);
  content.more_gps = {{3, ExifWriter::Text("")}};
  const ExifInfo exif = ReadBlock(ExifBlock(content));
  EXPECT_TRUE(exif.gps_lacks_hemisphere);
  EXPECT_NEAR(exif.gps.value().lon_deg(), 151.215297, 1e-7);
}

TEST(Exif, AVoidPositionIsNone) {
  ExifContent content = PhonePhoto(true);
  content.more_gps = {{9, ExifWriter::Text("V")}};
  const ExifInfo exif = ReadBlock(ExifBlock(content));
  EXPECT_FALSE(exif.gps.has_value());
  EXPECT_FALSE(exif.has_altitude);
  EXPECT_TRUE(exif.gps_is_void);
  content.more_gps = {{9, ExifWriter::Text("A")}};
  EXPECT_TRUE(ReadBlock(ExifBlock(content)).gps.has_value());
}

TEST(Exif, TimeIsSecondsSince1970) {
  const auto time_of = [](const std::string& text) {
    return ReadBlock(BlockWith({}, {{0x9003, ExifWriter::Text(text)}})).time_s;
  };
  EXPECT_EQ(time_of("1970:01:02 00:00:01"), 86401.0);
  EXPECT_EQ(time_of("2026:11:26 10:12:30"), 1795687950.0);
  EXPECT_FALSE(time_of("    :  :     :  :  "));
  EXPECT_FALSE(time_of("0000:00:00 00:00:00"));
  EXPECT_FALSE(time_of("2026"));
  EXPECT_FALSE(ReadBlock(BlockWith({}, {})).time_s);
}

TEST(Exif, CamerasOfOneKindHaveOneHash) {
  const auto kind_of = [](const std::string& make, const std::string& model) {
    return ReadBlock(
               BlockWith({{0x010f, ExifWriter::Text(make)}, {0x0110, ExifWriter::Text(model)}}, {}))
        .camera_kind;
  };
  EXPECT_EQ(kind_of("Maker", "One"), kind_of("Maker", "One"));
  EXPECT_NE(kind_of("Maker", "One"), kind_of("Maker", "Two"));
  EXPECT_EQ(ReadBlock(BlockWith({}, {})).camera_kind, 0u);
}

TEST(Exif, ALensThatZoomsIsSeveralKinds) {
  const ExifWriter writer(true);
  const auto kind_of = [&](double focal_mm, double digital_zoom) {
    return ReadBlock(BlockWith({{0x0110, ExifWriter::Text("One")}},
                               {{0x920a, writer.Rationals({focal_mm})},
                                {0xa404, writer.Rationals({digital_zoom})}}))
        .camera_kind;
  };
  EXPECT_EQ(kind_of(18, 1), kind_of(18, 1));
  EXPECT_EQ(kind_of(18, 0), kind_of(18, 1));  // 0 stands for none.
  EXPECT_NE(kind_of(18, 1), kind_of(55, 1));
  EXPECT_NE(kind_of(18, 1), kind_of(18, 2));
}

// A Canon of 3456 x 2304 pixels on 22.2 mm.
TEST(Exif, TheSensorTellsTheFocalLength) {
  const ExifWriter writer(true);
  testing::ExifDirectory exif = {{0x920a, writer.Rationals({24})}, {0xa002, writer.Long(3456)},
                                 {0xa003, writer.Long(2304)},      {0xa20e, writer.Long(3954)},
                                 {0xa20f, writer.Long(3959)},      {0xa210, writer.Short(2)}};
  const auto focal_35mm = [&](uint16_t tag, const testing::ExifEntry& entry) {
    testing::ExifDirectory changed = exif;
    changed[tag] = entry;
    return ReadBlock(BlockWith({}, changed)).focal_35mm.value_or(0.0);
  };
  EXPECT_NEAR(focal_35mm(0xa210, writer.Short(2)), 38.9, 0.1);
  EXPECT_NEAR(focal_35mm(0xa405, writer.Short(40)), 40.0, 1e-9);      // What is stated counts,
  EXPECT_NEAR(focal_35mm(0xa405, writer.Short(0)), 38.9, 0.1);        // 0 stands for nothing.
  EXPECT_NEAR(focal_35mm(0xa404, writer.Rationals({2})), 77.8, 0.2);  // Digital zoom.
  EXPECT_EQ(focal_35mm(0xa20e, writer.Rationals({0})), 0.0);
  EXPECT_EQ(focal_35mm(0xa20e, writer.Rationals({72})), 0.0);  // That of a screen.
  EXPECT_EQ(focal_35mm(0x920a, writer.Rationals({0})), 0.0);
  EXPECT_EQ(focal_35mm(0xa210, writer.Short(4)), 0.0);  // 0.9 mm would be no sensor.
  exif[0xa20e] = writer.Rationals({155.7});
  exif[0xa20f] = writer.Rationals({155.9});
  EXPECT_NEAR(focal_35mm(0xa210, writer.Short(4)), 38.9, 0.1);
}

TEST(Exif, TellsTheSizeBeforeACrop) {
  const ExifWriter writer(true);
  const ExifInfo exif =
      ReadBlock(BlockWith({}, {{0xa002, writer.Long(4000)}, {0xa003, writer.Short(3000)}}));
  EXPECT_EQ(exif.original_width_px, 4000);
  EXPECT_EQ(exif.original_height_px, 3000);
}

TEST(Exif, BothByteOrdersAndFormatsAreRead) {
  for (const bool is_little_endian : {true, false}) {
    const Bytes block = ExifBlock(PhonePhoto(is_little_endian));
    ExpectPhonePhoto(ReadBlock(block));
    ExpectPhonePhoto(ReadExif(PngWithExifBlock(Png(), block)));
    Bytes with_signature = {'E', 'x', 'i', 'f', 0, 0};
    with_signature.insert(with_signature.end(), block.begin(), block.end());
    ExpectPhonePhoto(ReadExif(PngWithExifBlock(Png(), with_signature)));
  }
}

TEST(Exif, NumbersOfOtherTypesAreRead) {
  for (const bool is_little_endian : {true, false}) {
    const ExifWriter writer(is_little_endian);
    const ExifEntry latitudes[] = {
        writer.Numbers(1, 1, {40}),                                         // Bytes.
        writer.Numbers(3, 2, {39, 60}),                                     // Shorts.
        writer.Numbers(4, 4, {40}),                                         // Longs.
        writer.Numbers(9, 4, {40}),                                         // Signed longs.
        ExifEntry{10, 1, writer.Numbers(10, 4, {4000, 100}).values},        // A signed rational.
        ExifEntry{5, 3, writer.Numbers(5, 4, {40, 1, 0, 0, 0, 0}).values},  // Minutes 0/0.
        writer.Numbers(11, 4, {0x42200000}),                                // A float.
        writer.Numbers(12, 8, {0x4044000000000000}),                        // A double.
    };
    for (const ExifEntry& latitude : latitudes) {
      ExifContent content = PhonePhoto(is_little_endian);
      content.lat_deg = 1.0;
      content.more_gps = {{2, latitude}};
      const ExifInfo exif = ReadBlock(ExifBlock(content));
      ASSERT_TRUE(exif.gps.has_value()) << latitude.type;
      EXPECT_NEAR(exif.gps->lat_deg(), 40.0, 1e-9) << latitude.type;
    }
  }
}

TEST(Exif, WhatIsNoPositionIsNone) {
  const ExifWriter writer(true);
  const std::vector<testing::ExifDirectory> bad = {
      {{2, writer.Rationals({0.0, 0.0, 0.0})}, {4, writer.Rationals({0.0, 0.0, 0.0})}},
      {{2, writer.Rationals({91.0, 0.0, 0.0})}},                    // Beyond the pole.
      {{4, writer.Rationals({180.0, 1.0, 0.0})}},                   // Beyond the antimeridian.
      {{2, ExifEntry{5, 1, writer.Numbers(5, 4, {1, 0}).values}}},  // 1/0 degrees.
      {{2, ExifEntry{5, 1, writer.Numbers(5, 4, {0, 0}).values}}},  // 0/0 degrees.
      {{2, ExifWriter::Text("33.85")}},                             // No number.
      {{2, writer.Numbers(12, 8, {0x7ff8000000000000})}},           // Not a number.
      {{2, ExifEntry{5, 0, {}}}},                                   // No values.
  };
  for (size_t i = 0; i < bad.size(); ++i) {
    ExifContent content = PhonePhoto(true);
    content.more_gps = bad[i];
    EXPECT_FALSE(ReadBlock(ExifBlock(content)).gps.has_value()) << i;
  }
  ExifContent on_the_equator = PhonePhoto(true);
  on_the_equator.lat_deg = 0.0;
  EXPECT_TRUE(ReadBlock(ExifBlock(on_the_equator)).gps.has_value());
}

TEST(Exif, AnErrorOfZeroIsUnknown) {
  ExifContent content = PhonePhoto(false);
  content.error_m = 0.0;
  EXPECT_FALSE(ReadBlock(ExifBlock(content)).gps_error_m.has_value());
}

// A position whose minutes are lost would be another position.
TEST(Exif, OfATruncatedBlockAValueIsWholeOrMissing) {
  for (const bool is_little_endian : {true, false}) {
    const Bytes whole = ExifBlock(PhonePhoto(is_little_endian));
    const ExifInfo all = ReadBlock(whole);
    for (size_t size = 0; size <= whole.size(); ++size) {
      const ExifInfo exif =
          ReadBlock(Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)));
      EXPECT_TRUE(exif.orientation == 1 || exif.orientation == 6) << size;
      if (exif.gps) {
        EXPECT_EQ(exif.gps->lat_rad, all.gps->lat_rad) << size;
        EXPECT_EQ(exif.gps->lon_rad, all.gps->lon_rad) << size;
      }
      EXPECT_TRUE(!exif.focal_35mm || exif.focal_35mm == 26.0) << size;
      EXPECT_TRUE(!exif.gps_error_m || exif.gps_error_m == all.gps_error_m) << size;
    }
  }
}

TEST(Exif, DamagedBytesGivePlausibleValues) {
  std::mt19937 random(7);
  for (const bool is_little_endian : {true, false}) {
    const Bytes whole = ExifBlock(PhonePhoto(is_little_endian));
    for (size_t i = 0; i < whole.size(); ++i) {
      for (const int mask : {0x01, 0x80, 0xff}) {
        Bytes damaged = whole;
        damaged[i] = static_cast<uint8_t>(damaged[i] ^ mask);
        ExpectPlausible(ReadBlock(damaged));
      }
    }
    for (int i = 0; i < 2000; ++i) {
      Bytes damaged = whole;
      for (int k = 0; k < 20; ++k) {
        damaged[random() % damaged.size()] = static_cast<uint8_t>(random());
      }
      ExpectPlausible(ReadBlock(damaged));
    }
  }
}

// Pointers of a directory to itself or to the first directory.
TEST(Exif, DirectoriesInACircleEnd) {
  const Bytes whole = ExifBlock(PhonePhoto(true));
  for (const size_t target : {size_t{8}, size_t{10}, whole.size() - 2}) {
    Bytes circle = whole;
    for (size_t at = 10; at + 12 <= 10 + 4 * 12; at += 12) {
      if (circle[at + 1] == 0x87 || circle[at + 1] == 0x88) {
        circle[at + 8] = static_cast<uint8_t>(target);
        circle[at + 9] = static_cast<uint8_t>(target >> 8);
      }
    }
    ExpectPlausible(ReadBlock(circle));
  }
}

// Each of thousands of entries claims all bytes of the block. A reader that copies the values of
// entries takes gigabytes for this.
TEST(Exif, OverlappingEntriesCostNothing) {
  const ExifWriter writer(true);
  constexpr uint32_t kNumBytes = 500'000;
  Bytes block = {'I', 'I', 42, 0, 8, 0, 0, 0};
  writer.Put(5000, 2, &block);
  for (uint32_t i = 0; i < 5000; ++i) {
    writer.Put(i == 0 ? 0x0112 : 0xa500 + i, 2, &block);
    writer.Put(i == 0 ? 3 : 1, 2, &block);
    writer.Put(i == 0 ? 1 : kNumBytes - 100, 4, &block);
    writer.Put(i == 0 ? 8 : 50, 4, &block);
  }
  block.resize(kNumBytes);
  const Bytes png = PngWithExifBlock(Png(), block);
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(ReadExif(png).orientation, 8);
  }
}

TEST(Exif, NothingBehindTheLimitIsRead) {
  ExifContent content = PhonePhoto(true);
  content.maker_note = Bytes(TiffDirectory::kMaxBytes, 0);  // The GPS directory follows.
  const ExifInfo exif = ReadExif(PngWithExifBlock(Png(), ExifBlock(content)));
  EXPECT_FALSE(exif.gps.has_value());
  EXPECT_EQ(exif.orientation, 6);
}

TEST(Exif, TheFirstOfTwoBlocksCounts) {
  ExifContent second = PhonePhoto(true);
  second.orientation = 3;
  const Bytes once = JpegWithExifBlock(Jpeg(), ExifBlock(second));
  EXPECT_EQ(ReadExif(JpegWithExifBlock(once, ExifBlock(PhonePhoto(true)))).orientation, 6);
}

TEST(Exif, ABlockWithoutEntriesIsPassedOver) {
  const Bytes real = JpegWithExifBlock(Jpeg(), ExifBlock(PhonePhoto(true)));
  for (const Bytes& first : {Bytes{}, Bytes{'I', 'I', 42, 0, 8, 0, 0, 0, 0, 0, 0, 0, 0, 0},
                             Bytes{'I', 'I', 42, 0, 255, 255, 255, 255, 0, 0}, Bytes(100, 0xff)}) {
    ExpectPhonePhoto(ReadExif(JpegWithExifBlock(real, first)));
    EXPECT_TRUE(ParseImageHeader(JpegWithExifBlock(Jpeg(), first)).HasExif() || first.empty());
  }
}

TEST(Exif, HemispheresMayHaveTheTypesOfBytes) {
  for (const uint16_t type : {1, 7}) {  // BYTE and UNDEFINED.
    ExifContent content = PhonePhoto(true);
    content.lon_deg = -151.215297;
    content.more_gps = {{1, ExifEntry{type, 2, {'S', 0}}}, {3, ExifEntry{type, 1, {'W'}}}};
    const ExifInfo exif = ReadBlock(ExifBlock(content));
    ASSERT_TRUE(exif.gps.has_value());
    EXPECT_NEAR(exif.gps->lat_deg(), -33.856784, 1e-7);
    EXPECT_NEAR(exif.gps->lon_deg(), -151.215297, 1e-7);
    EXPECT_FALSE(exif.gps_lacks_hemisphere);
  }
}

TEST(Exif, WhatIsNoTiffIsIgnored) {
  for (const Bytes& block :
       {Bytes{}, Bytes{'I', 'I'}, Bytes{'I', 'M', 42, 0, 8, 0, 0, 0}, Bytes{'M', 'M', 42, 0, 8, 0},
        Bytes{'I', 'I', 43, 0, 8, 0, 0, 0, 0, 0}, Bytes{'I', 'I', 42, 0, 255, 255, 255, 255, 0, 0},
        Bytes(60'000, 0xff)}) {
    const ExifInfo exif = ReadBlock(block);
    EXPECT_EQ(exif.orientation, 1);
    EXPECT_FALSE(exif.gps.has_value());
    EXPECT_EQ(exif.width_px, 640);
  }
}

TEST(Exif, StrayBytesBetweenSegmentsAreSkipped) {
  const Bytes photo = JpegWithExifBlock(Jpeg(), ExifBlock(PhonePhoto(true)));
  const size_t end_of_exif = photo.size() - Jpeg().size() + 2;
  for (const Bytes& stray : {Bytes{0}, Bytes{0, 0, 0}, Bytes{0x12, 0x34, 0xff, 0x00, 0x56},
                             Bytes{0xff, 0xff, 0xff}, Bytes{0xff, 0xd0, 0xff, 0x01}}) {
    for (const size_t at : {size_t{2}, end_of_exif}) {
      Bytes odd = photo;
      odd.insert(odd.begin() + static_cast<std::ptrdiff_t>(at), stray.begin(), stray.end());
      const ExifInfo exif = ReadExif(odd);
      EXPECT_EQ(exif.width_px, 640);
      ExpectPhonePhoto(exif);
    }
  }
}

TEST(ReadExif, ThePositionMayBeInTheXmp) {
  const ExifInfo drone = ReadXmp(
      "drone-dji:AbsoluteAltitude=\"+72.50\" drone-dji:GpsLatitude=\"+55.698\" "
      "drone-dji:GpsLongtitude=\"-13.195\"");
  ASSERT_TRUE(drone.gps.has_value());
  EXPECT_NEAR(drone.gps->lat_deg(), 55.698, 1e-9);
  EXPECT_NEAR(drone.gps->lon_deg(), -13.195, 1e-9);
  EXPECT_TRUE(drone.has_altitude);
  EXPECT_EQ(drone.gps->h_m, 72.5);
  const ExifInfo editor = ReadXmp(
      "exif:GPSLatitude='33,30.6S' exif:GPSAltitude='25/2' exif:GPSAltitudeRef='1'>"
      "<exif:GPSLongitude>70,30,36E</exif:GPSLongitude>");
  ASSERT_TRUE(editor.gps.has_value());
  EXPECT_NEAR(editor.gps->lat_deg(), -33.51, 1e-9);
  EXPECT_NEAR(editor.gps->lon_deg(), 70.51, 1e-9);
  EXPECT_EQ(editor.gps->h_m, -12.5);
}

TEST(ReadExif, PositionsOfXmpThatCannotBeAreNone) {
  for (const char* properties :
       {"drone-dji:GpsLatitude=\"0\" drone-dji:GpsLongitude=\"0\"",
        "drone-dji:GpsLatitude=\"95\" drone-dji:GpsLongitude=\"8\"",
        "drone-dji:GpsLatitude=\"nan\" drone-dji:GpsLongitude=\"8\"",
        "drone-dji:GpsLatitude=\"47\"", "exif:GPSLatitude='47,30' exif:GPSLongitude='8,30E'",
        "exif:GPSLatitude='47,30N' exif:GPSLongitude='8,30E", "exif:GPSLatitude=\"",
        "exif:GPSStatus='V' exif:GPSLatitude='47,3N' exif:GPSLongitude='8,3E'"}) {
    EXPECT_FALSE(ReadXmp(properties).gps.has_value()) << properties;
  }
}

}  // namespace
}  // namespace cairn
