// Reads EXIF that a PNG has as text. Private to core/images.
#ifndef CAIRN_CORE_IMAGES_RAW_PROFILE_H_
#define CAIRN_CORE_IMAGES_RAW_PROFILE_H_

#include <cstdint>
#include <span>
#include <vector>

namespace cairn {

// Before PNG had chunks for EXIF, ImageMagick and others wrote it as text with the keyword "Raw
// profile type exif" or "Raw profile type APP1": the name of the profile, its number of bytes, and
// two hexadecimal digits for each byte, with line breaks.

// Returns whether a chunk of a PNG, which begins with its type, is a text with such a keyword:
// plain (tEXt), compressed (zTXt), or either in Unicode (iTXt).
bool IsRawProfile(std::span<const uint8_t> typed_chunk);

// The TIFF structure of such a chunk, at most TiffDirectory::kMaxBytes; empty if the library cannot
// read the text, or if the text is longer than that takes, of which no more is inflated. A profile
// that is not EXIF is no TIFF structure.
std::vector<uint8_t> ReadRawProfile(std::span<const uint8_t> typed_chunk);

}  // namespace cairn

#endif  // CAIRN_CORE_IMAGES_RAW_PROFILE_H_
