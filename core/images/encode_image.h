// Encodes pictures as files.
#ifndef CAIRN_CORE_IMAGES_ENCODE_IMAGE_H_
#define CAIRN_CORE_IMAGES_ENCODE_IMAGE_H_

#include <cstddef>
#include <cstdint>
#include <vector>

namespace cairn {

// A picture to encode, which it does not own: rows from top to bottom, 8 bits a channel.
struct PictureRows {
  int width_px = 0;
  int height_px = 0;
  int num_channels = 1;  // 1: gray. 3: blue, green, red, as in OpenCV.
  const uint8_t* pixels = nullptr;
  size_t row_bytes = 0;  // From the beginning of a row to that of the next.
};

// All throw Error(kInternal) if the picture is empty or the library refuses it.

std::vector<uint8_t> EncodePng(const PictureRows& picture);

// `quality` is from 1 to 100.
std::vector<uint8_t> EncodeJpeg(const PictureRows& picture, int quality);

// Binary PGM of a gray picture, binary PPM of one in color.
std::vector<uint8_t> EncodePnm(const PictureRows& picture);

}  // namespace cairn

#endif  // CAIRN_CORE_IMAGES_ENCODE_IMAGE_H_
