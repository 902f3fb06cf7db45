#include "ingest/features/image_header.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <string>

#include "core/error.h"

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

uint32_t BigEndian16(Bytes bytes) { return uint32_t{bytes[0]} << 8 | bytes[1]; }
uint32_t BigEndian32(Bytes bytes) {
  return BigEndian16(bytes) << 16 | BigEndian16(bytes.subspan(2));
}

bool IsStartOfFrame(uint8_t marker) {
  // C4, C8 and CC are Huffman tables, a reserved extension and arithmetic conditioning.
  return marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
}

// In entropy-coded data every FF is followed by 00 or a restart marker, so FF D9 ends the image.
bool HasEndOfImage(Bytes entropy_coded) {
  constexpr std::array<uint8_t, 2> kEndOfImage = {0xff, 0xd9};
  return std::search(entropy_coded.begin(), entropy_coded.end(), kEndOfImage.begin(),
                     kEndOfImage.end()) != entropy_coded.end();
}

ImageHeader ParseJpeg(Bytes bytes) {
  ImageHeader header{.format = ImageFormat::kJpeg, .exif = {}};
  size_t at = 2;
  while (true) {
    while (at < bytes.size() && bytes[at] == 0xff) ++at;  // Marker prefix and fill bytes.
    if (at + 3 > bytes.size()) ThrowTruncated("JPEG");
    const uint8_t marker = bytes[at++];
    const size_t length = BigEndian16(bytes.subspan(at));
    if (length < 2 || length > bytes.size() - at) ThrowTruncated("JPEG");
    const Bytes segment = bytes.subspan(at + 2, length - 2);
    at += length;
    if (marker == 0xe1 && header.exif.empty() && StartsWith(segment, kExifSignature)) {
      header.exif = segment.subspan(kExifSignature.size());
    } else if (IsStartOfFrame(marker)) {
      if (segment.size() < 5) ThrowTruncated("JPEG");
      header.height_px = BigEndian16(segment.subspan(1));
      header.width_px = BigEndian16(segment.subspan(3));
    } else if (marker == 0xda) {  // Start of scan: pixels follow.
      if (!HasEndOfImage(bytes.subspan(at))) ThrowTruncated("JPEG");
      return header;
    }
  }
}

ImageHeader ParsePng(Bytes bytes) {
  ImageHeader header{.format = ImageFormat::kPng, .exif = {}};
  size_t at = kPngSignature.size();
  while (true) {
    if (bytes.size() - at < 12) ThrowTruncated("PNG");  // Length, type, checksum.
    const size_t length = BigEndian32(bytes.subspan(at));
    if (length > bytes.size() - at - 12) ThrowTruncated("PNG");
    const char* type = reinterpret_cast<const char*>(bytes.data()) + at + 4;
    const Bytes chunk = bytes.subspan(at + 8, length);
    at += 12 + length;
    if (std::memcmp(type, "IHDR", 4) == 0 && chunk.size() >= 8) {
      header.width_px = BigEndian32(chunk);
      header.height_px = BigEndian32(chunk.subspan(4));
    } else if (std::memcmp(type, "eXIf", 4) == 0) {
      header.exif = chunk;
    } else if (std::memcmp(type, "IEND", 4) == 0) {
      return header;
    }
  }
}

// Next decimal number of a PNM header; comments run from '#' to the end of the line.
int64_t ReadPnmNumber(Bytes bytes, size_t* at) {
  while (*at < bytes.size() && (bytes[*at] <= ' ' || bytes[*at] == '#')) {
    const bool is_comment = bytes[*at] == '#';
    ++*at;
    while (is_comment && *at < bytes.size() && bytes[*at] != '\n') ++*at;
  }
  int64_t number = 0;
  for (int num_digits = 0; *at < bytes.size() && bytes[*at] >= '0' && bytes[*at] <= '9'; ++*at) {
    number = number * 10 + (bytes[*at] - '0');
    if (++num_digits > 9) break;
  }
  return number;
}

ImageHeader ParsePnm(Bytes bytes) {
  ImageHeader header{.format = ImageFormat::kPnm, .exif = {}};
  size_t at = 2;
  header.width_px = ReadPnmNumber(bytes, &at);
  header.height_px = ReadPnmNumber(bytes, &at);
  const int64_t max_value = ReadPnmNumber(bytes, &at);
  if (at == bytes.size()) ThrowTruncated("PNM");
  ++at;  // One blank, then pixels.
  const uint64_t bytes_per_pixel = (bytes[1] == '6' ? 3 : 1) * (max_value > 255 ? 2 : 1);
  // Below 10^10 a side and 6 bytes a pixel: no overflow once one side is divided away.
  const uint64_t width = static_cast<uint64_t>(header.width_px);
  const uint64_t height = static_cast<uint64_t>(header.height_px);
  if (height != 0 && (bytes.size() - at) / height < width * bytes_per_pixel) ThrowTruncated("PNM");
  return header;
}

ImageHeader ParseByFormat(Bytes bytes) {
  if (bytes.size() >= 4 && bytes[0] == 0xff && bytes[1] == 0xd8) return ParseJpeg(bytes);
  if (StartsWith(bytes, kPngSignature)) return ParsePng(bytes);
  if (bytes.size() >= 2 && bytes[0] == 'P' && (bytes[1] == '5' || bytes[1] == '6')) {
    return ParsePnm(bytes);
  }
  throw Error(ErrorCode::kBadInput,
              "the bytes are not a JPEG, PNG or binary PGM/PPM image; convert it first");
}

}  // namespace

ImageHeader ParseImageHeader(std::span<const uint8_t> image_bytes) {
  const ImageHeader header = ParseByFormat(image_bytes);
  if (header.width_px < 1 || header.height_px < 1) {
    throw Error(ErrorCode::kBadInput, "the image header gives no size");
  }
  return header;
}

}  // namespace cairn
