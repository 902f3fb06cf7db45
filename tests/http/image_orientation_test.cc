#include "http/json/image_orientation.h"

#include <gtest/gtest.h>

#include <string>

#include "core/images/orient_image.h"

namespace cairn {
namespace {

// "ab/cd" is a picture of two rows.
GrayImage Picture(const std::string& rows) {
  GrayImage image;
  image.width_px = static_cast<int>(rows.find('/'));
  for (const char c : rows) {
    if (c != '/') {
      image.pixels.push_back(static_cast<uint8_t>(c));
    }
  }
  image.height_px = static_cast<int>(image.pixels.size()) / image.width_px;
  return image;
}

std::string Rows(const GrayImage& image) {
  std::string rows;
  for (size_t i = 0; i < image.pixels.size(); ++i) {
    if (i > 0 && i % image.width_px == 0) {
      rows += '/';
    }
    rows += static_cast<char>(image.pixels[i]);
  }
  return rows;
}

// What each of EXIF's orientations shows of the stored rows "abc/def": where its row 0 and its
// column 0 are, as the standard has it.
TEST(OrientImage, ShowsWhatExifSays) {
  const std::pair<int, const char*> shown[] = {
      {1, "abc/def"},   // Row 0 is the top, column 0 the left side.
      {2, "cba/fed"},   // Top, right side.
      {3, "fed/cba"},   // Bottom, right side.
      {4, "def/abc"},   // Bottom, left side.
      {5, "ad/be/cf"},  // Left side, top.
      {6, "da/eb/fc"},  // Right side, top.
      {7, "fc/eb/da"},  // Right side, bottom.
      {8, "cf/be/ad"},  // Left side, bottom.
  };
  for (const auto& [orientation, rows] : shown) {
    EXPECT_EQ(Rows(OrientImage(Picture("abc/def"), orientation)), rows) << orientation;
  }
}

TEST(OrientationToApply, FollowsTheSizeUnlessTheRequestSays) {
  const PictureHeader portrait{4000, 3000, 6};
  EXPECT_EQ(OrientationToApply(portrait, ImageOrientation::kAsSize, 4000, 3000), 1);
  EXPECT_EQ(OrientationToApply(portrait, ImageOrientation::kAsSize, 3000, 4000), 6);
  EXPECT_EQ(OrientationToApply(portrait, ImageOrientation::kAsSize, 100, 200), 1);
  EXPECT_EQ(OrientationToApply(portrait, ImageOrientation::kStored, 3000, 4000), 1);
  EXPECT_EQ(OrientationToApply(portrait, ImageOrientation::kUpright, 4000, 3000), 6);
  const PictureHeader upside_down{4000, 3000, 3};
  EXPECT_EQ(OrientationToApply(upside_down, ImageOrientation::kAsSize, 4000, 3000), 1);
  EXPECT_EQ(OrientationToApply(upside_down, ImageOrientation::kUpright, 4000, 3000), 3);
  const PictureHeader plain{4000, 3000, 1};
  EXPECT_EQ(OrientationToApply(plain, ImageOrientation::kAsSize, 3000, 4000), 1);
}

TEST(ImageOrientation, NamesGoBothWays) {
  EXPECT_EQ(ImageOrientationFromName("stored"), ImageOrientation::kStored);
  EXPECT_EQ(ImageOrientationFromName("upright"), ImageOrientation::kUpright);
  EXPECT_EQ(ImageOrientationFromName("exif"), std::nullopt);
}

}  // namespace
}  // namespace cairn
