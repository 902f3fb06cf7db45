// Reads the header of an image file without decoding pixels.
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
  // The TIFF structure of the EXIF block, as a view of the parsed bytes; empty if there is none.
  std::span<const uint8_t> exif;
};

// Walks the segments of a JPEG (T.81 annex B), the chunks of a PNG, or the header of a binary PGM
// or PPM. Reads nothing outside `image_bytes` and allocates nothing. Throws Error(kBadInput) if the
// bytes have none of these formats or end before the size. JPEG and PNG must also have their end
// marker, so that a truncated upload is refused instead of decoded half gray.
ImageHeader ParseImageHeader(std::span<const uint8_t> image_bytes);

}  // namespace cairn

#endif  // CAIRN_INGEST_IMAGES_IMAGE_HEADER_H_
