// Tests the image decoders on files of other programs and on invalid files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/images/gray_image.h"
#include "core/images/image_header.h"
#include "core/images/orient_image.h"
#include "support/test_data.h"

namespace cairn {
namespace {

using ::testing::HasSubstr;
using Bytes = std::vector<uint8_t>;

Bytes BytesOf(const std::string& text) { return {text.begin(), text.end()}; }

// A picture with slopes, edges and noise; `type` as CV_8UC3.
cv::Mat Picture(int type) {
  const int max = CV_MAT_DEPTH(type) == CV_16U ? 65535 : 255;
  cv::Mat picture(123, 157, type);
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      for (int c = 0; c < picture.channels(); ++c) {
        const int value = (x * (c + 2) * 3 + y * 2 + (x / 16 + y / 16) % 2 * 90 + x * y * 7 % 31) %
                          256 * max / 255;
        if (max == 255) {
          picture.ptr(y)[x * picture.channels() + c] = static_cast<uint8_t>(value);
        } else {
          picture.ptr<uint16_t>(y)[x * picture.channels() + c] = static_cast<uint16_t>(value);
        }
      }
    }
  }
  return picture;
}

Bytes Encode(const std::string& extension, int type, const std::vector<int>& parameters = {}) {
  Bytes bytes;
  cv::imencode(extension, Picture(type), bytes, parameters);
  return bytes;
}

// The largest difference from what OpenCV, a user of the same libraries, makes of the file.
int DifferenceFromOpenCv(const Bytes& bytes) {
  const GrayImage ours = DecodeGrayImage(bytes);
  const cv::Mat theirs = cv::imdecode(bytes, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
  if (theirs.cols != ours.width_px || theirs.rows != ours.height_px) {
    return 256;
  }
  int largest = 0;
  for (size_t i = 0; i < ours.pixels.size(); ++i) {
    largest = std::max(largest, std::abs(int{ours.pixels[i]} - int{theirs.data[i]}));
  }
  return largest;
}

// What the decoder says of a file that it refuses.
std::string Refusal(const Bytes& bytes) {
  try {
    DecodeGrayImage(bytes);
    return "accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::kBadInput);
    return e.what();
  }
}

Bytes HostileFile(const std::string& name) {
  return ReadImageBytes((testing::TestDataDir() / "hostile" / name).string());
}

TEST(ImageDecoding, JpegsAreGrayAsByOpenCv) {
  for (const int type : {CV_8UC1, CV_8UC3}) {
    for (const int quality : {30, 90, 100}) {
      EXPECT_EQ(DifferenceFromOpenCv(Encode(".jpg", type, {cv::IMWRITE_JPEG_QUALITY, quality})), 0);
    }
    EXPECT_EQ(DifferenceFromOpenCv(Encode(".jpg", type, {cv::IMWRITE_JPEG_PROGRESSIVE, 1})), 0);
    EXPECT_EQ(DifferenceFromOpenCv(Encode(".jpg", type, {cv::IMWRITE_JPEG_RST_INTERVAL, 3})), 0);
  }
}

TEST(ImageDecoding, PngsAreGrayAsByOpenCv) {
  for (const int type : {CV_8UC1, CV_8UC3, CV_8UC4, CV_16UC1, CV_16UC3, CV_16UC4}) {
    EXPECT_EQ(DifferenceFromOpenCv(Encode(".png", type)), 0) << type;
  }
  EXPECT_EQ(DifferenceFromOpenCv(Encode(".png", CV_8UC1, {cv::IMWRITE_PNG_BILEVEL, 1})), 0);
}

TEST(ImageDecoding, PnmsAreGrayAsByOpenCv) {
  EXPECT_EQ(DifferenceFromOpenCv(Encode(".pgm", CV_8UC1)), 0);
  EXPECT_EQ(DifferenceFromOpenCv(Encode(".ppm", CV_8UC3)), 0);
  EXPECT_LE(DifferenceFromOpenCv(Encode(".pgm", CV_16UC1)),
            1);  // OpenCV cuts, the rest is rounded.
  EXPECT_LE(DifferenceFromOpenCv(Encode(".ppm", CV_16UC3)), 1);
}

TEST(ImageDecoding, PnmCommentsStandAnywhereBeforeThePixels) {
  const Bytes expected = {'#', '\n', 'a', 'b', 'c', 'd'};
  for (const char* head : {"P5 3 2 255\n", "P5\n# 9 9\n3 2\n255\n", "P5#x\r3#y\n2\t255 ",
                           "P5 3 2 255#z\n", "P5\n#\n#\n\n3\n#255\n2\n# 1\n255\n"}) {
    const GrayImage image = DecodeGrayImage(BytesOf(std::string(head) + "#\nabcd"));
    EXPECT_EQ(image.width_px, 3) << head;
    EXPECT_EQ(image.height_px, 2) << head;
    EXPECT_EQ(image.pixels, expected) << head;
  }
  for (const char* bad :
       {"P5 3 2 255\n#\nabc", "P53 2 255\n#\nabcd", "P5 3 2\n#\nabcd", "P5 3 -2 255\n",
        "P5 0 2 255\n#\nabcd", "P5 3 2 0\n#\nabcd", "P5 3 2 70000\n#\nabcd",
        "P5 99999999999 2 255\n#\nabcd", "P5 3 2 255", "P5 3x2 255\n#\nabcd"}) {
    EXPECT_THAT(Refusal(BytesOf(bad)), HasSubstr("PNM")) << bad;
  }
}

TEST(ImageDecoding, PnmSamplesAreScaled) {
  EXPECT_EQ(DecodeGrayImage(BytesOf("P5 3 1 3\n\x01\x03\x7f")).pixels, (Bytes{85, 255, 255}));
  EXPECT_EQ(DecodeGrayImage(BytesOf(std::string("P5 2 1 1023\n\x03\xff\x01\xff", 16))).pixels,
            (Bytes{255, 127}));
}

TEST(ImageDecoding, OtherFormatsAreRefusedByName) {
  EXPECT_THAT(Refusal(BytesOf("GIF89a.............")), HasSubstr("GIF"));
  EXPECT_THAT(Refusal(Encode(".tiff", CV_8UC1)), HasSubstr("TIFF"));
  EXPECT_THAT(Refusal(Encode(".bmp", CV_8UC1)), HasSubstr("BMP"));
  EXPECT_THAT(Refusal(Encode(".webp", CV_8UC3)), HasSubstr("WebP"));
  EXPECT_THAT(Refusal(BytesOf("hello, world")), HasSubstr("not a JPEG, PNG"));
}

TEST(ImageDecoding, AJpegOfFourColorsIsRefused) {
  const Bytes cmyk = {0xff, 0xd8,                                                         // Start.
                      0xff, 0xc0, 0, 20, 8,    0, 8, 0, 8,  4, 1, 0x11, 0,   2, 0x11, 0,  // Frame
                      3,    0x11, 0, 4,  0x11, 0,                               // of four.
                      0xff, 0xda, 0, 8,  1,    1, 0, 0, 63, 0, 0, 0xff, 0xd9};  // Scan, end.
  EXPECT_THAT(Refusal(cmyk), HasSubstr("one nor three components"));
}

TEST(ImageDecoding, DamagedPixelsAreRefusedOrDecodedButNothingElse) {
  for (const Bytes& whole :
       {Encode(".jpg", CV_8UC3), Encode(".jpg", CV_8UC1, {cv::IMWRITE_JPEG_PROGRESSIVE, 1}),
        Encode(".png", CV_8UC3), Encode(".ppm", CV_8UC3)}) {
    for (size_t i = 2; i < whole.size(); i += 1 + whole.size() / 300) {
      Bytes damaged = whole;
      damaged[i] ^= 0x55;
      try {
        EXPECT_FALSE(DecodeGrayImage(damaged).pixels.empty());
      } catch (const Error& e) {
        EXPECT_EQ(e.code(), ErrorCode::kBadInput);
      }
    }
  }
}

// Some JPEGs, in one scan and in several.
// Phones and editors state the projection of a panorama in its XMP.
TEST(ImageDecoding, APanoramaIsRefused) {
  Bytes jpeg = Encode(".jpg", CV_8UC3);
  const std::string xmp = std::string("http://ns.adobe.com/xap/1.0/") + '\0' +
                          "<rdf:Description GPano:ProjectionType=\"cylindrical\"/>";
  Bytes segment = {0xff, 0xe1, 0, static_cast<uint8_t>(xmp.size() + 2)};
  segment.insert(segment.end(), xmp.begin(), xmp.end());
  jpeg.insert(jpeg.begin() + 2, segment.begin(), segment.end());
  EXPECT_THAT(Refusal(jpeg), HasSubstr("panorama"));
}

std::vector<Bytes> JpegsOfAllKinds() {
  return {Encode(".jpg", CV_8UC3), Encode(".jpg", CV_8UC1),
          Encode(".jpg", CV_8UC3, {cv::IMWRITE_JPEG_PROGRESSIVE, 1}),
          Encode(".jpg", CV_8UC3, {cv::IMWRITE_JPEG_RST_INTERVAL, 3})};
}

TEST(ImageDecoding, AJpegWithoutEndMarkerIsWhole) {
  for (const Bytes& whole : JpegsOfAllKinds()) {
    const Bytes without(whole.begin(), whole.end() - 2);
    EXPECT_EQ(DecodeGrayImage(without).pixels, DecodeGrayImage(whole).pixels);
    Bytes padded = without;
    padded.resize(padded.size() + 100);
    EXPECT_EQ(DecodeGrayImage(padded).pixels, DecodeGrayImage(whole).pixels);
  }
}

// The last bits of the data may be padding.
TEST(ImageDecoding, OfACutJpegNoPixelIsMadeUp) {
  for (const Bytes& whole : JpegsOfAllKinds()) {
    const GrayImage image = DecodeGrayImage(whole);
    int num_refused = 0;
    for (size_t num_lost = 3; num_lost < whole.size() / 2; num_lost += 1 + num_lost / 4) {
      Bytes cut(whole.begin(), whole.end() - static_cast<std::ptrdiff_t>(num_lost));
      try {
        EXPECT_EQ(DecodeGrayImage(cut).pixels, image.pixels) << num_lost;
      } catch (const Error& e) {
        EXPECT_THAT(e.what(), HasSubstr("cut short"));
        ++num_refused;
      }
    }
    EXPECT_GE(num_refused, 10);
  }
}

// A file whose end has not arrived, on a disk that keeps its place.
TEST(ImageDecoding, AJpegOfWhichHalfIsZerosIsRefused) {
  for (const Bytes& whole : JpegsOfAllKinds()) {
    Bytes half = whole;
    std::fill(half.begin() + static_cast<std::ptrdiff_t>(half.size() / 2), half.end(), 0);
    EXPECT_NE(Refusal(half), "accepted");
  }
}

TEST(ImageDecoding, StrayBytesBetweenTheSegmentsOfAJpegAreSkipped) {
  for (const Bytes& whole : JpegsOfAllKinds()) {
    for (const Bytes& stray : {Bytes{0}, Bytes{0x12, 0x34, 0xff, 0x00, 0x56}, Bytes(1000, 0)}) {
      const size_t end_of_first = 4 + (size_t{whole[4]} << 8 | whole[5]);
      for (const size_t at : {size_t{2}, end_of_first}) {
        Bytes odd = whole;
        odd.insert(odd.begin() + static_cast<std::ptrdiff_t>(at), stray.begin(), stray.end());
        EXPECT_EQ(DecodeGrayImage(odd).pixels, DecodeGrayImage(whole).pixels);
      }
    }
  }
}

// A JPEG of 158 x 123 pixels with a bright spot.
Bytes JpegOfASpot(const std::vector<int>& parameters = {}) {
  cv::Mat picture(123, 158, CV_8UC3);
  for (int y = 0; y < picture.rows; ++y) {
    for (int x = 0; x < picture.cols; ++x) {
      const double dx = x + 0.5 - 101.3, dy = y + 0.5 - 40.7;
      const auto value = static_cast<uint8_t>(250.0 * std::exp(-(dx * dx + dy * dy) / 200.0));
      picture.at<cv::Vec3b>(y, x) = {value, value, value};
    }
  }
  Bytes bytes;
  cv::imencode(".jpg", picture, bytes, parameters);
  return bytes;
}

// The middle of the spot, in pixels of the picture that the image shows.
std::pair<double, double> Spot(const GrayImage& image) {
  double sum = 0.0, sum_x = 0.0, sum_y = 0.0;
  for (size_t i = 0; i < image.pixels.size(); ++i) {
    const double weight = std::max(0, image.pixels[i] - 8);
    sum += weight;
    sum_x += weight * (static_cast<double>(i % image.width_px) + 0.5);
    sum_y += weight * (static_cast<double>(i / image.width_px) + 0.5);
  }
  const FullPicture full = image.full.value_or(FullPicture());
  return {full.left_px + full.pixel_px * sum_x / sum, full.top_px + full.pixel_px * sum_y / sum};
}

TEST(ImageDecoding, AJpegAboveTheLimitIsDecodedAtASmallerScale) {
  const Bytes bytes = JpegOfASpot();
  constexpr int64_t kNumPixels = 158 * 123;
  EXPECT_FALSE(DecodeGrayImage(bytes, {.max_pixels = kNumPixels}).full.has_value());
  for (const int64_t max_pixels :
       {kNumPixels - 1, kNumPixels / 2, kNumPixels / 4, kNumPixels / 10}) {
    const GrayImage small = DecodeGrayImage(bytes, {.max_pixels = max_pixels});
    ASSERT_TRUE(small.full.has_value()) << max_pixels;
    EXPECT_LE(static_cast<int64_t>(small.pixels.size()), max_pixels);
    EXPECT_GE(static_cast<int64_t>(small.pixels.size()), max_pixels / 2);
    EXPECT_EQ(small.picture_width_px(), 158);
    EXPECT_EQ(small.picture_height_px(), 123);
    EXPECT_NEAR(Spot(small).first, 101.3, 0.3) << max_pixels;
    EXPECT_NEAR(Spot(small).second, 40.7, 0.3) << max_pixels;
  }
}

TEST(ImageDecoding, ASmallerImageIsTurnedInItsPicture) {
  const Bytes bytes = JpegOfASpot();
  const GrayImage whole = DecodeGrayImage(bytes);
  const GrayImage small = DecodeGrayImage(bytes, {.max_pixels = 158 * 123 / 8});
  for (int orientation = 1; orientation <= 8; ++orientation) {
    const GrayImage expected = OrientImage(whole, orientation);
    const GrayImage turned = OrientImage(small, orientation);
    EXPECT_EQ(turned.picture_width_px(), expected.width_px) << orientation;
    EXPECT_NEAR(Spot(turned).first, Spot(expected).first, 0.3) << orientation;
    EXPECT_NEAR(Spot(turned).second, Spot(expected).second, 0.3) << orientation;
  }
}

// What the decoder says of a file that has more pixels than the limit.
std::string RefusalWithin(const Bytes& bytes, int64_t max_pixels) {
  try {
    DecodeGrayImage(bytes, {.max_pixels = max_pixels});
    return "accepted";
  } catch (const Error& e) {
    return e.what();
  }
}

TEST(ImageDecoding, OtherImagesAboveTheLimitAreRefusedWithWords) {
  EXPECT_THROW(DecodeGrayImage(Encode(".png", CV_8UC3), {.max_pixels = 1000}), ImageTooLarge);
  EXPECT_THAT(RefusalWithin(Encode(".png", CV_8UC3), 1000),
              HasSubstr("157 x 123 pixels, more than the limit of 1000 for PNG; save it as JPEG"));
  EXPECT_THAT(RefusalWithin(Encode(".ppm", CV_8UC3), 1000), HasSubstr("for PNM; save it as JPEG"));
  EXPECT_THAT(RefusalWithin(JpegOfASpot(), 1000), HasSubstr("limit of 16000 for JPEG; scale it"));
}

// All coefficients of a progressive image are in memory at once, whatever the scale.
TEST(ImageDecoding, ALargeProgressiveJpegIsRefused) {
  constexpr int64_t kNumPixels = 158 * 123;
  EXPECT_EQ(RefusalWithin(JpegOfASpot(), kNumPixels / 10), "accepted");
  const Bytes progressive = JpegOfASpot({cv::IMWRITE_JPEG_PROGRESSIVE, 1});
  EXPECT_EQ(RefusalWithin(progressive, kNumPixels / 2), "accepted");
  EXPECT_THAT(RefusalWithin(progressive, kNumPixels / 10), HasSubstr("baseline JPEG"));
}

// How often the decoder asks whether it should stop; it is told so the `stop_at`-th time.
int NumQuestions(const Bytes& bytes, int stop_at) {
  int num_questions = 0;
  const auto decode = [&] {
    DecodeGrayImage(bytes, {.should_stop = [&] { return ++num_questions == stop_at; }});
  };
  if (stop_at > 0) {
    EXPECT_THROW(decode(), DecodingStopped);
  } else {
    decode();
  }
  return num_questions;
}

TEST(ImageDecoding, StopsWhenItIsTold) {
  for (const char* extension : {".jpg", ".png", ".ppm"}) {
    const Bytes bytes = Encode(extension, CV_8UC3);
    const int num_questions = NumQuestions(bytes, 0);
    EXPECT_GE(num_questions, 7) << extension;
    for (int stop_at = 1; stop_at <= num_questions; ++stop_at) {
      EXPECT_EQ(NumQuestions(bytes, stop_at), stop_at) << extension;
    }
  }
}

// Writes a number of 32 bits as PNG does.
void PutBigEndian(uint32_t value, uint8_t* bytes) {
  for (int i = 0; i < 4; ++i) {
    bytes[i] = static_cast<uint8_t>(value >> (24 - 8 * i));
  }
}

// As PNG defines it.
uint32_t CrcOf(const uint8_t* begin, const uint8_t* end) {
  uint32_t crc = 0xffffffff;
  for (const uint8_t* byte = begin; byte != end; ++byte) {
    crc ^= *byte;
    for (int bit = 0; bit < 8; ++bit) {
      crc = (crc >> 1) ^ ((crc & 1) != 0 ? 0xedb88320 : 0);
    }
  }
  return ~crc;
}

// A PNG of the first rows of a picture whose data holds all rows.
Bytes PngWithMoreData(const cv::Mat& picture, int height) {
  constexpr size_t kHeight = 20, kHeadType = 12, kHeadCrc = 29;  // Offsets of parts of IHDR.
  Bytes bytes;
  cv::imencode(".png", picture, bytes);
  PutBigEndian(static_cast<uint32_t>(height), &bytes[kHeight]);
  PutBigEndian(CrcOf(&bytes[kHeadType], &bytes[kHeadCrc]), &bytes[kHeadCrc]);
  return bytes;
}

// 32 MB of such data inflate to 32 GB, after the last row.
TEST(ImageDecoding, APngIsInflatedToItsLastRowOnly) {
  cv::Mat noise(2000, 1000, CV_8UC1);
  cv::randu(noise, 0, 256);
  for (const int height : {40, 41}) {
    const Bytes bytes = PngWithMoreData(noise, height);
    const GrayImage image = DecodeGrayImage(bytes);
    ASSERT_EQ(image.height_px, height);
    EXPECT_TRUE(std::equal(image.pixels.begin(), image.pixels.end(), noise.data));
    const auto num_pieces = static_cast<int>(bytes.size() >> 14);
    EXPECT_LT(NumQuestions(bytes, 0), num_pieces / 10);
  }
}

TEST(ImageDecoding, EveryScanOfAJpegAsks) {
  constexpr int kRowsOfBlocks = 8;
  constexpr int kNumScans = 10;  // As libjpeg writes them.
  EXPECT_GE(NumQuestions(Encode(".jpg", CV_8UC3, {cv::IMWRITE_JPEG_PROGRESSIVE, 1}), 0),
            NumQuestions(Encode(".jpg", CV_8UC3), 0) + (kNumScans - 1) * kRowsOfBlocks);
}

// A progressive JPEG whose first scan comes `count` times.
Bytes WithFirstScanRepeated(int count) {
  const Bytes whole = Encode(".jpg", CV_8UC1, {cv::IMWRITE_JPEG_PROGRESSIVE, 1});
  const Bytes start_of_scan = {0xff, 0xda};
  const auto begin =
      std::search(whole.begin(), whole.end(), start_of_scan.begin(), start_of_scan.end());
  auto end = begin + 2;
  while (end[0] != 0xff || end[1] == 0) {
    ++end;  // To the next marker.
  }
  Bytes repeated(whole.begin(), begin);
  for (int i = 0; i < count; ++i) {
    repeated.insert(repeated.end(), begin, end);
  }
  repeated.insert(repeated.end(), end, whole.end());
  return repeated;
}

TEST(ImageDecoding, AJpegOfManyScansIsRefused) {
  EXPECT_EQ(Refusal(WithFirstScanRepeated(50)), "accepted");
  EXPECT_THAT(Refusal(WithFirstScanRepeated(150)), HasSubstr("more than 100 scans"));
}

TEST(ImageDecoding, SmallJpegsThatTakeMinutesAreRefused) {
  CAIRN_SKIP_WITHOUT_DATA("hostile/progressive_jpeg_2000_scans.jpg");
  for (const char* name : {"progressive_jpeg_2000_scans.jpg", "progressive_jpeg_72000_scans.jpg"}) {
    const std::clock_t start = std::clock();
    EXPECT_THAT(Refusal(HostileFile(name)), HasSubstr("does not decode"));
    EXPECT_LT(std::clock() - start, 8 * CLOCKS_PER_SEC);  // 0.1 s; all scans take 18 s or more.
  }
}

TEST(ImageDecoding, TextChunksAreNotUnpacked) {
  CAIRN_SKIP_WITHOUT_DATA("hostile/png_240_zTXt.png");
  const Bytes bytes = HostileFile("png_240_zTXt.png");
  const std::clock_t start = std::clock();
  EXPECT_EQ(DecodeGrayImage(bytes).width_px, 640);
  EXPECT_LT(std::clock() - start, 4 * CLOCKS_PER_SEC);  // 0.02 s; to unpack them takes 8 s or more.
}

TEST(ImageDecoding, ASecondHeaderIsRefused) {
  CAIRN_SKIP_WITHOUT_DATA("hostile/png_two_IHDR_30000x30000_then_640x480.png");
  EXPECT_THAT(Refusal(HostileFile("png_two_IHDR_30000x30000_then_640x480.png")),
              HasSubstr("its only header"));
}

}  // namespace
}  // namespace cairn
