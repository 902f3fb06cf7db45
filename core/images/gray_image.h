// Gray images, and functions that read them from image files.
#ifndef CAIRN_CORE_IMAGES_GRAY_IMAGE_H_
#define CAIRN_CORE_IMAGES_GRAY_IMAGE_H_

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/images/image_header.h"

namespace cairn {

// A picture that a GrayImage shows at a smaller scale.
struct FullPicture {
  int width_px = 0;
  int height_px = 0;
  double pixel_px = 1.0;  // Side of a pixel of the image, in pixels of the picture.
  // The upper left corner of the image, in pixels of the picture.
  double left_px = 0.0;
  double top_px = 0.0;
};

// An 8-bit gray image, row-major.
struct GrayImage {
  int width_px = 0;
  int height_px = 0;
  std::vector<uint8_t> pixels;  // width * height.
  // Set if the image shows a picture at a smaller scale. Cameras, keypoints and matches refer to
  // the pixels of the picture, not to those of the image.
  std::optional<FullPicture> full = {};

  // The size of the picture.
  int picture_width_px() const { return full ? full->width_px : width_px; }
  int picture_height_px() const { return full ? full->height_px : height_px; }
};

// A black image.
GrayImage BlankImage(int64_t width_px, int64_t height_px);

struct ImageDecodeLimits {
  // The most pixels of a decoded image. Holds the 4032 x 3024 of a phone's photo of 12 megapixels,
  // and as many of a photo of 48 megapixels at half its scale.
  int64_t max_pixels = 12'500'000;
  // Polled every few rows, in every pass of a progressive image. Decoding stops when it returns
  // true. Must not throw. If empty, nothing stops the decoding.
  std::function<bool()> should_stop = {};

  // A JPEG may have this many times max_pixels, because it is decoded at a smaller scale: 200
  // megapixels, the largest sensor of a phone (16,320 x 12,240).
  static constexpr int kMaxJpegReduction = 16;
};

// Thrown by decoders when `should_stop` returns true.
class DecodingStopped : public Error {
 public:
  DecodingStopped() : Error(ErrorCode::kUnavailable, "the decoding of an image was stopped") {}
};

// Thrown before decoding if an image has too many pixels. The message has the size, the limit and
// what to do.
class ImageTooLarge : public Error {
 public:
  explicit ImageTooLarge(const std::string& message) : Error(ErrorCode::kBadInput, message) {}
};

// An image file: its bytes and the decoded image.
struct Photo {
  std::vector<uint8_t> bytes;
  GrayImage image;
};

// Throws ImageTooLarge if an image with this header has more pixels than the limits allow.
void RequireDecodableSize(const ImageHeader& header, const ImageDecodeLimits& limits);

// Decodes JPEG, PNG and binary PGM/PPM. Ignores EXIF rotation, because camera intrinsics refer to
// the stored pixels. A JPEG of more than `limits.max_pixels` is decoded at the largest scale of n/8
// that has no more; the result then has `full`. The pixels of other images are those of the file.
// Throws Error(kBadInput) if the bytes have another format, do not decode, are cut short or are a
// panorama (ImageHeader::is_panorama); ImageTooLarge; DecodingStopped.
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

#endif  // CAIRN_CORE_IMAGES_GRAY_IMAGE_H_
