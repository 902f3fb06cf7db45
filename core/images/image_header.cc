#include "core/images/image_header.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>

#include "core/error.h"
#include "core/images/pnm_decoder.h"
#include "core/images/raw_profile.h"
#include "core/images/tiff_directory.h"

namespace cairn {
namespace {

using Bytes = std::span<const uint8_t>;

constexpr std::array<uint8_t, 8> kPngSignature = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
constexpr std::array<uint8_t, 6> kExifSignature = {'E', 'x', 'i', 'f', 0, 0};

[[noreturn]] void ThrowTruncated(const char* format) {
  throw Error(ErrorCode::kBadInput, std::string("the ") + format + " image is cut short");
}

template <size_t N>
bool StartsWith(Bytes bytes, const std::array<uint8_t, N>& prefix) {
  return bytes.size() >= N && std::equal(prefix.begin(), prefix.end(), bytes.begin());
}

// Some writers put the signature of JPEG's EXIF segment into PNG, too.
Bytes WithoutExifSignature(Bytes exif) {
  return StartsWith(exif, kExifSignature) ? exif.subspan(kExifSignature.size()) : exif;
}

// Editors leave blocks that are empty or damaged before the camera's own.
void TakeExif(Bytes block, ImageHeader* header) {
  const Bytes exif = WithoutExifSignature(block);
  const bool is_better =
      TiffDirectory::First(header->exif).IsEmpty() && !TiffDirectory::First(exif).IsEmpty();
  if (header->exif.empty() || is_better) {
    header->exif = exif;
  }
}

uint32_t BigEndian16(Bytes bytes) { return uint32_t{bytes[0]} << 8 | bytes[1]; }
uint32_t BigEndian32(Bytes bytes) {
  return BigEndian16(bytes) << 16 | BigEndian16(bytes.subspan(2));
}

bool IsStartOfFrame(uint8_t marker) {
  // C4, C8 and CC are Huffman tables, a reserved extension and arithmetic conditioning.
  return marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
}

// Restart markers and TEM have no length and no content.
bool StandsAlone(uint8_t marker) { return (marker >= 0xd0 && marker <= 0xd7) || marker == 0x01; }

// Moves `at` behind the next marker and returns the marker. Some cameras write stray bytes between
// segments; like libjpeg, this skips bytes up to the next FF that is followed by neither FF nor 00.
uint8_t NextMarker(Bytes bytes, size_t* at) {
  while (true) {
    while (*at < bytes.size() && bytes[*at] != 0xff) {
      ++*at;
    }
    while (*at < bytes.size() && bytes[*at] == 0xff) {
      ++*at;
    }
    if (*at >= bytes.size()) {
      ThrowTruncated("JPEG");
    }
    const uint8_t marker = bytes[(*at)++];
    if (marker != 0 && !StandsAlone(marker)) {
      return marker;
    }
  }
}

// Moves `at` behind the segment and returns its content.
Bytes NextSegment(Bytes bytes, size_t* at) {
  constexpr size_t kLengthBytes = 2;
  if (bytes.size() - *at < kLengthBytes) {
    ThrowTruncated("JPEG");
  }
  const size_t length = BigEndian16(bytes.subspan(*at));
  if (length < kLengthBytes || length > bytes.size() - *at) {
    ThrowTruncated("JPEG");
  }
  const Bytes content = bytes.subspan(*at + kLengthBytes, length - kLengthBytes);
  *at += length;
  return content;
}

// The first block that is XMP counts: what does not fit into it, and is no place, follows in
// others.
void TakeXmp(Bytes block, ImageHeader* header) {
  constexpr std::string_view kSignature("http://ns.adobe.com/xap/1.0/\0", 29);
  const std::string_view text(reinterpret_cast<const char*>(block.data()), block.size());
  header->is_panorama |= text.find("GPano:ProjectionType") != text.npos;
  if (header->xmp.empty() && text.starts_with(kSignature)) {
    header->xmp = text.substr(kSignature.size());
  }
}

ImageHeader ParseJpeg(Bytes bytes) {
  constexpr uint8_t kApp1 = 0xe1, kEndOfImage = 0xd9, kStartOfScan = 0xda;
  ImageHeader header{.format = ImageFormat::kJpeg, .exif = {}, .raw_profile = {}};
  size_t at = 2;
  while (true) {
    const uint8_t marker = NextMarker(bytes, &at);
    if (marker == kEndOfImage) {
      throw Error(ErrorCode::kBadInput, "the JPEG image ends before its pixels");
    }
    const Bytes segment = NextSegment(bytes, &at);
    if (marker == kApp1 && StartsWith(segment, kExifSignature)) {
      TakeExif(segment, &header);
    } else if (marker == kApp1) {
      TakeXmp(segment, &header);
    } else if (IsStartOfFrame(marker)) {
      if (segment.size() < 5) {
        ThrowTruncated("JPEG");
      }
      header.height_px = BigEndian16(segment.subspan(1));
      header.width_px = BigEndian16(segment.subspan(3));
    } else if (marker == kStartOfScan) {  // Pixels follow.
      return header;
    }
  }
}

ImageHeader ParsePng(Bytes bytes) {
  ImageHeader header{.format = ImageFormat::kPng, .exif = {}, .raw_profile = {}};
  size_t at = kPngSignature.size();
  bool is_first = true;
  while (true) {
    if (bytes.size() - at < 12) {
      ThrowTruncated("PNG");  // Length, type, checksum.
    }
    const size_t length = BigEndian32(bytes.subspan(at));
    if (length > bytes.size() - at - 12) {
      ThrowTruncated("PNG");
    }
    const char* type = reinterpret_cast<const char*>(bytes.data()) + at + 4;
    const Bytes typed_chunk = bytes.subspan(at + 4, 4 + length);
    const Bytes chunk = typed_chunk.subspan(4);
    at += 12 + length;
    const bool is_header = std::memcmp(type, "IHDR", 4) == 0;
    // The header must come first and only once. For two headers, decoders disagree about which one
    // counts.
    if (is_header != std::exchange(is_first, false) || (is_header && length != 13)) {
      throw Error(ErrorCode::kBadInput, "the PNG image does not begin with its only header");
    }
    if (is_header) {
      header.width_px = BigEndian32(chunk);
      header.height_px = BigEndian32(chunk.subspan(4));
    } else if (std::memcmp(type, "eXIf", 4) == 0) {
      TakeExif(chunk, &header);
    } else if (header.raw_profile.empty() && IsRawProfile(typed_chunk)) {
      header.raw_profile = typed_chunk;
    } else if (std::memcmp(type, "IEND", 4) == 0) {
      return header;
    }
  }
}

ImageHeader ParsePnm(Bytes bytes) {
  const PnmHeader pnm = ParsePnmHeader(bytes);
  return {.format = ImageFormat::kPnm,
          .width_px = pnm.width_px,
          .height_px = pnm.height_px,
          .exif = {},
          .raw_profile = {}};
}

// Formats that a sender may assume to be supported.
struct OtherFormat {
  const char* name;
  size_t at;
  std::string_view magic;
};
constexpr OtherFormat kOtherFormats[] = {
    {"GIF", 0, "GIF8"},
    {"TIFF", 0, std::string_view("II*\0", 4)},
    {"TIFF", 0, std::string_view("MM\0*", 4)},
    {"BMP", 0, "BM"},
    {"WebP", 8, "WEBP"},
    {"HEIC or AVIF", 4, "ftyp"},
    {"JPEG 2000", 4, "jP  "},
    {"text PNM", 0, "P2"},
    {"text PNM", 0, "P3"},
};

std::string FormatName(Bytes bytes) {
  if (bytes.empty()) {
    return "the file is empty, and not";
  }
  if (IsVideo(bytes)) {
    return "the file is a video, not";
  }
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  for (const OtherFormat& format : kOtherFormats) {
    if (text.substr(std::min(format.at, text.size())).starts_with(format.magic)) {
      return std::string("the image is a ") + format.name + ", not";
    }
  }
  return "the bytes are not";
}

ImageHeader ParseByFormat(Bytes bytes) {
  if (bytes.size() >= 4 && bytes[0] == 0xff && bytes[1] == 0xd8) {
    return ParseJpeg(bytes);
  }
  if (StartsWith(bytes, kPngSignature)) {
    return ParsePng(bytes);
  }
  if (bytes.size() >= 2 && bytes[0] == 'P' && (bytes[1] == '5' || bytes[1] == '6')) {
    return ParsePnm(bytes);
  }
  throw Error(ErrorCode::kBadInput,
              FormatName(bytes) + " a JPEG, PNG or binary PGM/PPM image; convert it first");
}

}  // namespace

const char* ImageFormatName(ImageFormat format) {
  switch (format) {
    case ImageFormat::kJpeg:
      return "JPEG";
    case ImageFormat::kPng:
      return "PNG";
    case ImageFormat::kPnm:
      break;
  }
  return "PNM";
}

bool IsVideo(std::span<const uint8_t> bytes) {
  constexpr size_t kTypeAt = 4, kBrandAt = 8;
  constexpr std::string_view kBrands[] = {"qt  ", "iso", "mp4",  "avc1", "M4V",
                                          "3gp",  "3g2", "MSNV", "XAVC"};
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return text.size() > kBrandAt && text.substr(kTypeAt).starts_with("ftyp") &&
         std::any_of(std::begin(kBrands), std::end(kBrands), [&](std::string_view brand) {
           return text.substr(kBrandAt).starts_with(brand);
         });
}

ImageHeader ParseImageHeader(std::span<const uint8_t> image_bytes) {
  const ImageHeader header = ParseByFormat(image_bytes);
  if (header.width_px < 1 || header.height_px < 1) {
    throw Error(ErrorCode::kBadInput, "the image header gives no size");
  }
  return header;
}

}  // namespace cairn
