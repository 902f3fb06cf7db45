// Grey images, and reading them from image files.
#ifndef CAIRN_INGEST_IMAGES_GRAY_IMAGE_H_
#define CAIRN_INGEST_IMAGES_GRAY_IMAGE_H_

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/error.h"

namespace cairn {

// An 8-bit grey image, row-major.
struct GrayImage {
  int width_px = 0;
  int height_px = 0;
  std::vector<uint8_t> pixels;  // width * height.
};

// A black image.
GrayImage BlankImage(int64_t width_px, int64_t height_px);

struct ImageDecodeLimits {
  int64_t max_pixels = 12'000'000;
  // Asked every few rows, in every pass of a progressive image; true ends the decoding. Must not
  // throw. Empty: nothing does.
  std::function<bool()> should_stop = {};
};

// What a decoder throws when `should_stop` said so.
class DecodingStopped : public Error {
 public:
  DecodingStopped() : Error(ErrorCode::kUnavailable, "the decoding of an image was stopped") {}
};

// An image file, as it is and decoded.
struct Photo {
  std::vector<uint8_t> bytes;
  GrayImage image;
};

// Decodes JPEG, PNG and binary PGM/PPM, ignoring EXIF rotation (camera intrinsics refer to the
// stored pixels). Throws Error(kBadInput) if the bytes are none of these, do not decode or are cut
// short, or if the header claims more pixels than the limit (checked before decoding), and
// DecodingStopped.
GrayImage DecodeGrayImage(std::span<const uint8_t> image_bytes,
                          const ImageDecodeLimits& limits = {});

// An image file's bytes, as a server is sent them. Throws as ReadFileBytes; at most 256 MiB.
std::vector<uint8_t> ReadImageBytes(const std::string& path);

// Reads and decodes a file; throws as ReadImageBytes or as DecodeGrayImage, naming the path.
Photo ReadPhoto(const std::string& path, const ImageDecodeLimits& limits = {});

// ReadPhoto without the file's bytes.
GrayImage ReadGrayImage(const std::string& path, const ImageDecodeLimits& limits = {});

}  // namespace cairn

#endif  // CAIRN_INGEST_IMAGES_GRAY_IMAGE_H_
