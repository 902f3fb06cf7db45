// Encodes photos as files.
#ifndef CAIRN_EVAL_PICTURES_ENCODE_PNG_H_
#define CAIRN_EVAL_PICTURES_ENCODE_PNG_H_

#include <cstdint>
#include <vector>

#include "core/images/gray_image.h"

namespace cairn {

// Returns the bytes of a lossless PNG file. Throws Error(kInternal) if the image is empty.
std::vector<uint8_t> EncodePng(const GrayImage& image);

}  // namespace cairn

#endif  // CAIRN_EVAL_PICTURES_ENCODE_PNG_H_
