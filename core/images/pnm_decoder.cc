#include "core/images/pnm_decoder.h"

#include <algorithm>
#include <string>

#include "core/error.h"

namespace cairn {
namespace {

using Bytes = std::span<const uint8_t>;

constexpr int64_t kMaxSidePx = 1'000'000'000;
constexpr int64_t kMaxSample = 65535;

[[noreturn]] void Refuse(const char* what) {
  throw Error(ErrorCode::kBadInput, std::string("the PNM image ") + what);
}

bool IsBlank(uint8_t c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

// The next byte of the header outside comments.
uint8_t NextByte(Bytes bytes, size_t* at) {
  if (*at < bytes.size() && bytes[*at] == '#') {
    while (*at < bytes.size() && bytes[*at] != '\n' && bytes[*at] != '\r') {
      ++*at;
    }
  }
  if (*at >= bytes.size()) {
    Refuse("is cut short");
  }
  return bytes[(*at)++];
}

// Reads the next number and the blank after it.
int64_t ReadNumber(Bytes bytes, size_t* at, int64_t max) {
  uint8_t c = NextByte(bytes, at);
  while (IsBlank(c)) {
    c = NextByte(bytes, at);
  }
  int64_t number = 0;
  for (; !IsBlank(c); c = NextByte(bytes, at)) {
    if (c < '0' || c > '9') {
      Refuse("has a header with something other than numbers");
    }
    number = number * 10 + (c - '0');
    if (number > max) {
      Refuse("has a number in its header that is too large");
    }
  }
  if (number < 1) {
    Refuse("has a number in its header that is not positive");
  }
  return number;
}

// Reads a sample and scales it to 255.
uint32_t Sample(const uint8_t* bytes, int max_value) {
  const auto max = static_cast<uint32_t>(max_value);
  const uint32_t value = max > 255 ? uint32_t{bytes[0]} << 8 | bytes[1] : bytes[0];
  return (std::min(value, max) * 255 + max / 2) / max;
}

void DecodeRow(const PnmHeader& header, const uint8_t* samples, uint8_t* gray) {
  const int sample_bytes = header.max_value > 255 ? 2 : 1;
  const int64_t width = header.width_px;
  if (header.samples_per_pixel == 1 && header.max_value == 255) {
    std::copy(samples, samples + width, gray);
    return;
  }
  for (int64_t x = 0; x < width; ++x) {
    const uint8_t* pixel = samples + x * header.samples_per_pixel * sample_bytes;
    const auto sample = [&](int i) { return Sample(pixel + i * sample_bytes, header.max_value); };
    // ITU-R BT.601 luma in units of 1/2^14.
    gray[x] = static_cast<uint8_t>(
        header.samples_per_pixel == 1
            ? sample(0)
            : (4899 * sample(0) + 9617 * sample(1) + 1868 * sample(2) + 8192) >> 14);
  }
}

}  // namespace

PnmHeader ParsePnmHeader(Bytes bytes) {
  PnmHeader header;
  header.samples_per_pixel = bytes[1] == '6' ? 3 : 1;
  size_t at = 2;
  if (bytes.size() > at && !IsBlank(bytes[at]) && bytes[at] != '#') {
    Refuse("has no blank after its magic number");
  }
  header.width_px = ReadNumber(bytes, &at, kMaxSidePx);
  header.height_px = ReadNumber(bytes, &at, kMaxSidePx);
  header.max_value = static_cast<int>(ReadNumber(bytes, &at, kMaxSample));
  header.pixels_at = at;
  const int64_t row_bytes =
      header.width_px * header.samples_per_pixel * (header.max_value > 255 ? 2 : 1);
  if (static_cast<int64_t>(bytes.size() - at) / header.height_px < row_bytes) {
    Refuse("is cut short");
  }
  return header;
}

GrayImage DecodePnm(Bytes bytes, const ImageDecodeLimits& limits) {
  const PnmHeader header = ParsePnmHeader(bytes);
  GrayImage image = BlankImage(header.width_px, header.height_px);
  const size_t width = static_cast<size_t>(header.width_px);
  const size_t row_bytes = width * header.samples_per_pixel * (header.max_value > 255 ? 2 : 1);
  for (size_t y = 0; y < static_cast<size_t>(header.height_px); ++y) {
    if (y % 16 == 0 && limits.should_stop && limits.should_stop()) {
      throw DecodingStopped();
    }
    DecodeRow(header, bytes.data() + header.pixels_at + y * row_bytes,
              image.pixels.data() + y * width);
  }
  return image;
}

}  // namespace cairn
