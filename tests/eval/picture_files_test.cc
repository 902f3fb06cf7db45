// Tests the files that pictures become, by decoders of others.
#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/images/encode_image.h"
#include "eval/pictures/label.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

// A picture of odd size with a color gradient, cut out of a larger one so that its rows are apart.
cv::Mat Gradient() {
  cv::Mat large(40, 60, CV_8UC3);
  for (int y = 0; y < large.rows; ++y) {
    for (int x = 0; x < large.cols; ++x) {
      large.at<cv::Vec3b>(y, x) = {static_cast<uint8_t>(4 * x), static_cast<uint8_t>(5 * y),
                                   static_cast<uint8_t>(2 * (x + y))};
    }
  }
  return large(cv::Rect(5, 3, 33, 21));
}

double LargestDifference(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() ? cv::norm(a, b, cv::NORM_INF) : 1e9;
}

TEST(WritePicture, KeepsEachPixelInLosslessFormats) {
  const testing::TempDir dir;
  for (const std::string name : {"a.png", "a.PPM"}) {
    WritePicture(dir.File(name), Gradient());
    EXPECT_EQ(LargestDifference(cv::imread(dir.File(name)), Gradient()), 0.0) << name;
  }
}

TEST(WritePicture, IsCloseInJpeg) {
  const testing::TempDir dir;
  WritePicture(dir.File("a.jpg"), Gradient());
  EXPECT_LT(LargestDifference(cv::imread(dir.File("a.jpg")), Gradient()), 30.0);
}

TEST(WritePicture, RefusesOtherFormatsAndFolders) {
  const testing::TempDir dir;
  EXPECT_THROW(WritePicture(dir.File("a.gif"), Gradient()), Error);
  EXPECT_THROW(WritePicture(dir.File("missing/a.png"), Gradient()), Error);
}

TEST(EncodeImage, RefusesAnEmptyPicture) {
  EXPECT_THROW(EncodePng(PictureRows()), Error);
  EXPECT_THROW(EncodeJpeg(PictureRows(), 90), Error);
  EXPECT_THROW(EncodePnm(PictureRows()), Error);
}

TEST(EncodeImage, RefusesWhatJpegCannotHold) {
  const std::vector<uint8_t> row(70'000, 0);  // More than 65,500 pixels.
  EXPECT_THROW(EncodeJpeg({70'000, 1, 1, row.data(), row.size()}, 90), Error);
}

}  // namespace
}  // namespace cairn
