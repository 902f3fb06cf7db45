// Tests EXIF that a PNG has as text.
#include "core/images/raw_profile.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <string>
#include <vector>

#include "core/images/exif.h"
#include "core/images/image_header.h"
#include "core/images/tiff_directory.h"
#include "support/exif_bytes.h"

namespace cairn {
namespace {

using testing::ExifBlock;
using testing::ExifContent;
using testing::PngWithChunk;
using Bytes = std::vector<uint8_t>;

// The header and the end of a 64 x 48 PNG.
Bytes SmallPng() {
  return {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n',                                  //
          0,    0,   0,   13,  'I',  'H',  'D',  'R',  0, 0, 0, 64, 0, 0, 0, 48, 8, 0,  //
          0,    0,   0,   0,   0,    0,    0,                                           //
          0,    0,   0,   0,   'I',  'E',  'N',  'D',  0, 0, 0, 0};
}

Bytes PlacedBlock() {
  ExifContent content;
  content.lat_deg = 55.5;
  content.lon_deg = 13.25;
  content.orientation = 6;
  return ExifBlock(content);
}

// The bytes as ImageMagick writes a profile.
std::string ProfileText(const Bytes& bytes) {
  std::string text = "\nexif\n    " + std::to_string(bytes.size());
  for (size_t i = 0; i < bytes.size(); ++i) {
    text += i % 36 == 0 ? "\n" : "";
    text += "0123456789abcdef"[bytes[i] / 16];
    text += "0123456789abcdef"[bytes[i] % 16];
  }
  return text + "\n";
}

Bytes Deflated(const std::string& text) {
  uLongf size = compressBound(text.size());
  Bytes deflated(size);
  compress(deflated.data(), &size, reinterpret_cast<const Bytef*>(text.data()), text.size());
  deflated.resize(size);
  return deflated;
}

Bytes PlainChunk(const std::string& keyword, const std::string& text) {
  const std::string content = keyword + '\0' + text;
  return Bytes(content.begin(), content.end());
}

Bytes CompressedChunk(const std::string& keyword, const std::string& text) {
  Bytes chunk = PlainChunk(keyword, std::string(1, '\0'));
  const Bytes deflated = Deflated(text);
  chunk.insert(chunk.end(), deflated.begin(), deflated.end());
  return chunk;
}

// The text behind the fields of iTXt: not compressed, no language, no translated keyword.
std::string Unicode(const std::string& text) { return std::string(4, '\0') + text; }

void ExpectPlaced(const Bytes& png) {
  const ExifInfo exif = ReadExif(png);
  ASSERT_TRUE(exif.gps.has_value());
  EXPECT_NEAR(exif.gps->lat_deg(), 55.5, 1e-7);
  EXPECT_NEAR(exif.gps->lon_deg(), 13.25, 1e-7);
  EXPECT_EQ(exif.orientation, 6);
  EXPECT_TRUE(ParseImageHeader(png).HasExif());
}

TEST(RawProfile, IsReadPlainAndCompressed) {
  Bytes with_signature = {'E', 'x', 'i', 'f', 0, 0};
  const Bytes block = PlacedBlock();
  with_signature.insert(with_signature.end(), block.begin(), block.end());
  for (const std::string keyword : {"Raw profile type exif", "Raw profile type APP1"}) {
    for (const Bytes& bytes : {block, with_signature}) {
      const std::string text = ProfileText(bytes);
      ExpectPlaced(PngWithChunk(SmallPng(), "tEXt", PlainChunk(keyword, text)));
      ExpectPlaced(PngWithChunk(SmallPng(), "iTXt", PlainChunk(keyword, Unicode(text))));
      ExpectPlaced(PngWithChunk(SmallPng(), "zTXt", CompressedChunk(keyword, text)));
    }
  }
}

TEST(RawProfile, OtherTextsAreNone) {
  const std::string text = ProfileText(PlacedBlock());
  for (const char* keyword : {"Raw profile type xmp", "Raw profile type exif2", "Comment"}) {
    const Bytes png = PngWithChunk(SmallPng(), "tEXt", PlainChunk(keyword, text));
    EXPECT_FALSE(ParseImageHeader(png).HasExif()) << keyword;
    EXPECT_FALSE(ReadExif(png).gps.has_value()) << keyword;
  }
}

TEST(RawProfile, TheChunkForExifCountsBeforeIt) {
  ExifContent other;
  other.orientation = 3;
  const Bytes png = PngWithChunk(SmallPng(), "tEXt",
                                 PlainChunk("Raw profile type exif", ProfileText(PlacedBlock())));
  EXPECT_EQ(ReadExif(testing::PngWithExifBlock(png, ExifBlock(other))).orientation, 3);
}

TEST(RawProfile, DamagedChunksNeverCrash) {
  const std::string text = ProfileText(PlacedBlock());
  const std::string keyword = "Raw profile type exif";
  const auto read = [](const char* type, const Bytes& chunk) {
    const int orientation = ReadExif(PngWithChunk(SmallPng(), type, chunk)).orientation;
    EXPECT_TRUE(orientation >= 1 && orientation <= 8);
  };
  for (const char* type : {"tEXt", "zTXt"}) {
    const Bytes whole = *type == 'z' ? CompressedChunk(keyword, text) : PlainChunk(keyword, text);
    for (size_t i = 0; i < whole.size(); ++i) {
      read(type, Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(i)));
      Bytes flipped = whole;
      flipped[i] ^= 0xff;
      read(type, flipped);
    }
  }
}

TEST(RawProfile, NoMoreThanTheLimitIsInflated) {
  const auto num_bytes_of = [](size_t num_digits) {
    const std::string text = "\nexif\n 1\n" + std::string(num_digits, '0');
    Bytes chunk = CompressedChunk("Raw profile type exif", text);
    const std::string type = "zTXt";
    chunk.insert(chunk.begin(), type.begin(), type.end());
    return ReadRawProfile(chunk).size();
  };
  EXPECT_EQ(num_bytes_of(2 * TiffDirectory::kMaxBytes), TiffDirectory::kMaxBytes);
  EXPECT_EQ(num_bytes_of(2 * TiffDirectory::kMaxBytes + 100), TiffDirectory::kMaxBytes);
  EXPECT_EQ(num_bytes_of(100'000'000), 0u);
}

}  // namespace
}  // namespace cairn
