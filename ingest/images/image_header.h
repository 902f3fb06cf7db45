// What the first bytes of an image file say, read without decoding any pixel.
#ifndef CAIRN_INGEST_IMAGES_IMAGE_HEADER_H_
#define CAIRN_INGEST_IMAGES_IMAGE_HEADER_H_

#include <cstdint>
#include <span>

namespace cairn {

enum class ImageFormat { kJpeg, kPng, kPnm };

struct ImageHeader {
  ImageFormat format = ImageFormat::kJpeg;
  int64_t width_px = 0;   // At least 1.
  int64_t height_px = 0;  // At least 1.
  // The TIFF structure of the EXIF block, inside the bytes parsed; empty if there is none.
  std::span<const uint8_t> exif;
};

// Walks the segments of a JPEG (T.81 annex B), the chunks of a PNG, or the header of a binary PGM
// or PPM. Reads nothing outside `image_bytes` and allocates nothing. Throws Error(kBadInput) if the
// bytes are none of these formats or end before the size (JPEG, PNG: before the end marker, so that
// a truncated upload is refused rather than decoded half grey).
ImageHeader ParseImageHeader(std::span<const uint8_t> image_bytes);

}  // namespace cairn

#endif  // CAIRN_INGEST_IMAGES_IMAGE_HEADER_H_
