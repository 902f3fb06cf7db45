// Tests that the page /ui reads the EXIF of photos as the server does.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/open_page.h"
#include "cli/run_cairn.h"
#include "core/images/encode_image.h"
#include "core/images/exif.h"
#include "core/images/gray_image.h"
#include "core/images/photo_camera.h"
#include "eval/pictures/encode_png.h"
#include "http/json/request_photos.h"
#include "support/exif_bytes.h"
#include "support/temp_dir.h"

namespace cairn::testing {
namespace {

using ::nlohmann::json;
using Bytes = std::vector<uint8_t>;

ExifContent PlacedPhoto(const ExifDirectory& more_gps) {
  ExifContent content;
  content.lat_deg = -33.856784;
  content.lon_deg = -70.5;
  content.error_m = 4.75;
  content.more_gps = more_gps;
  return content;
}

// A Canon of 3456 x 2304 pixels on 22.2 mm.
ExifContent PhotoOfASensor(const ExifDirectory& more) {
  const ExifWriter writer(true);
  ExifContent content;
  content.more_exif = more;
  content.more_exif.insert({{0x920a, writer.Rationals({24})},
                            {0xa002, writer.Long(3456)},
                            {0xa003, writer.Long(2304)},
                            {0xa20e, writer.Long(3954)},
                            {0xa20f, writer.Long(3959)},
                            {0xa210, writer.Short(2)}});
  return content;
}

// The blocks of photos between which readers may differ.
std::vector<ExifContent> Contents() {
  const ExifWriter writer(true);
  const ExifDirectory gps[] = {
      {},
      {{1, ExifWriter::Text("s")}, {3, ExifWriter::Text("w")}},
      {{1, ExifEntry{1, 2, {'S', 0}}}, {3, ExifEntry{7, 1, {'w'}}}},  // Types of bytes.
      {{9, ExifWriter::Text("V")}},
      {{9, ExifWriter::Text("A")}},
      {{0x1f, writer.Rationals({0.0})}},
      {{2, writer.Numbers(12, 8, {0x4044000000000000})}},  // 40 degrees as a double.
      {{2, writer.Numbers(9, 4, {uint64_t(-33)})}},
      {{2, writer.Rationals({91.0})}},
      {{2, ExifEntry{5, 1, writer.Numbers(5, 4, {1, 0}).values}}},  // 1/0 degrees.
      {{2, writer.Rationals({0.0})}, {4, writer.Rationals({0.0})}},
  };
  const ExifDirectory cameras[] = {
      {},
      {{0xa405, writer.Short(40)}},
      {{0xa405, writer.Short(0)}},
      {{0xa405, writer.Short(3)}},  // No camera has that.
      {{0xa404, writer.Rationals({2})}},
      {{0xa20e, writer.Rationals({0})}},
      {{0xa20e, writer.Rationals({72})}},  // That of a screen.
      {{0xa20e, writer.Rationals({1556})}, {0xa210, writer.Short(3)}},
  };
  std::vector<ExifContent> contents;
  for (const ExifDirectory& more : gps) {
    contents.push_back(PlacedPhoto(more));
  }
  for (const ExifDirectory& more : cameras) {
    contents.push_back(PhotoOfASensor(more));
  }
  return contents;
}

Bytes BlankJpeg() {
  const Bytes pixels(16 * 16, 0);
  return EncodeJpeg({.width_px = 16, .height_px = 16, .pixels = pixels.data(), .row_bytes = 16},
                    90);
}

// What the server reads in the photo, as the page writes it.
json AsServerReads(const Bytes& photo) {
  const ExifInfo exif = ReadExif(photo);
  json read = json::object();
  if (const std::optional<PositionPrior> prior = PriorOfPhoto(exif)) {
    read["gps"] = {{"lat", prior->position.lat_deg()},
                   {"lon", prior->position.lon_deg()},
                   {"accuracy", prior->accuracy_m}};
  }
  const PhotoCamera camera = CameraOfPhoto(exif, 3600, 2400);
  if (!camera.focal.with_distortion) {
    read["focal35mm"] = camera.camera.params()[0] / 100.0;
  }
  return read;
}

void ExpectSame(const json& page, const json& server) {
  const json flat_page = page.flatten(), flat_server = server.flatten();
  for (const auto& [name, value] : flat_server.items()) {
    if (value.is_number()) {
      EXPECT_NEAR(flat_page.value(name, 0.0), value.get<double>(), 1e-9) << name << page;
    }
  }
  for (const auto& [name, value] : flat_page.items()) {
    EXPECT_TRUE(value.is_null() || flat_server.contains(name)) << page << server;
  }
}

TEST(PageExif, IsReadAsTheServerReadsIt) {
  if (const std::string why_not = WhyNoBrowser(); !why_not.empty()) {
    GTEST_SKIP() << why_not;
  }
  const TempDir dir;
  std::vector<Bytes> photos;
  json paths = json::array();
  const Bytes blank = EncodePng(BlankImage(16, 16));
  for (const ExifContent& content : Contents()) {
    photos.push_back(PngWithExifBlock(blank, ExifBlock(content)));
  }
  const Bytes jpeg = JpegWithExifBlock(BlankJpeg(), ExifBlock(PlacedPhoto({})));
  photos.push_back(JpegWithExifBlock(jpeg, {'I', 'I', 42, 0, 8, 0, 0, 0, 0, 0, 0, 0, 0, 0}));
  for (size_t i = 0; i < photos.size(); ++i) {
    paths.push_back(dir.File(std::to_string(i) + ".photo"));
    std::ofstream(paths.back().get<std::string>(), std::ios::binary)
        .write(reinterpret_cast<const char*>(photos[i].data()),
               static_cast<std::streamsize>(photos[i].size()));
  }
  const std::string map = dir.File("map.gpkg");
  ASSERT_EQ(RunCairn({"init", map}).exit_code, 0);
  BackgroundCairn server({"serve", map, "--port", "0", "--log-level", "off"});
  const json seen = OpenPage({{"url", server.ReadLine()}, {"exif", paths}}, dir);
  ASSERT_EQ(seen.value("exif", json::array()).size(), photos.size()) << seen;
  for (size_t i = 0; i < photos.size(); ++i) {
    SCOPED_TRACE(i);
    ExpectSame(seen["exif"][i], AsServerReads(photos[i]));
  }
}

}  // namespace
}  // namespace cairn::testing
