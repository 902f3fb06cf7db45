// Reads the header of an image file without decoding pixels.
#ifndef CAIRN_CORE_IMAGES_IMAGE_HEADER_H_
#define CAIRN_CORE_IMAGES_IMAGE_HEADER_H_

#include <cstdint>
#include <span>
#include <string_view>

namespace cairn {

enum class ImageFormat { kJpeg, kPng, kPnm };
const char* ImageFormatName(ImageFormat format);  // "JPEG", "PNG", "PNM".

struct ImageHeader {
  ImageFormat format = ImageFormat::kJpeg;
  int64_t width_px = 0;   // At least 1.
  int64_t height_px = 0;  // At least 1.
  // The TIFF structure of the EXIF block, as a view of the parsed bytes; empty if there is none. Of
  // several blocks, the first whose directory has entries, or else the first.
  std::span<const uint8_t> exif;
  // A text chunk of a PNG with the EXIF as digits, as a view (raw_profile.h); empty if there is
  // none.
  std::span<const uint8_t> raw_profile;
  // The XMP of a JPEG, as a view of the parsed bytes; empty if there is none.
  std::string_view xmp = {};
  // A JPEG whose XMP states a projection (GPano:ProjectionType), as phones and editors write for
  // panoramas: no lens makes such a picture.
  bool is_panorama = false;

  bool HasExif() const { return !exif.empty() || !raw_profile.empty(); }
};

// Walks the segments of a JPEG (T.81 annex B), the chunks of a PNG, or the header of a binary PGM
// or PPM. Reads nothing outside `image_bytes` and allocates nothing. Skips stray bytes between the
// segments of a JPEG, which some cameras write. Throws Error(kBadInput) if the bytes have none of
// these formats, end before the size, or are a JPEG without pixels or a PNG without its end marker.
// Whether the pixels of a JPEG are complete shows only when they are decoded.
ImageHeader ParseImageHeader(std::span<const uint8_t> image_bytes);

// Returns whether the bytes begin as an MP4, QuickTime or 3GP video does, whose container is that
// of HEIC and AVIF.
bool IsVideo(std::span<const uint8_t> bytes);

}  // namespace cairn

#endif  // CAIRN_CORE_IMAGES_IMAGE_HEADER_H_
