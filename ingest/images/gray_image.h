// Gray images, and functions that read them from image files.
#ifndef CAIRN_INGEST_IMAGES_GRAY_IMAGE_H_
#define CAIRN_INGEST_IMAGES_GRAY_IMAGE_H_

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/error.h"

namespace cairn {

// An 8-bit gray image, row-major.
struct GrayImage {
  int width_px = 0;
  int height_px = 0;
  std::vector<uint8_t> pixels;  // width * height.
};

// A black image.
GrayImage BlankImage(int64_t width_px, int64_t height_px);

struct ImageDecodeLimits {
  int64_t max_pixels = 12'000'000;
  // Polled every few rows, in every pass of a progressive image. Decoding stops when it returns
  // true. Must not throw. If empty, nothing stops the decoding.
  std::function<bool()> should_stop = {};
};

// Thrown by decoders when `should_stop` returns true.
class DecodingStopped : public Error {
 public:
  DecodingStopped() : Error(ErrorCode::kUnavailable, "the decoding of an image was stopped") {}
};

// An image file: its bytes and the decoded image.
struct Photo {
  std::vector<uint8_t> bytes;
  GrayImage image;
};

// Decodes JPEG, PNG and binary PGM/PPM. Ignores EXIF rotation, because camera intrinsics refer to
// the stored pixels. Throws Error(kBadInput) if the bytes are none of these formats, do not decode
// or are cut short, or if the header states more pixels than the limit (checked before decoding).
// Throws DecodingStopped.
GrayImage DecodeGrayImage(std::span<const uint8_t> image_bytes,
                          const ImageDecodeLimits& limits = {});

// The bytes of an image file, in the form that a server receives. At most 256 MiB. Throws as
// ReadFileBytes.
std::vector<uint8_t> ReadImageBytes(const std::string& path);

// Reads and decodes a file. Throws as ReadImageBytes and DecodeGrayImage; the message names the
// path.
Photo ReadPhoto(const std::string& path, const ImageDecodeLimits& limits = {});

// Like ReadPhoto, without the bytes of the file.
GrayImage ReadGrayImage(const std::string& path, const ImageDecodeLimits& limits = {});

}  // namespace cairn

#endif  // CAIRN_INGEST_IMAGES_GRAY_IMAGE_H_
