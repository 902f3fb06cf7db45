// One photo of a folder: its features and what its EXIF says.
#ifndef CAIRN_MAPPING_PHOTOS_READ_PHOTO_H_
#define CAIRN_MAPPING_PHOTOS_READ_PHOTO_H_

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/features/feature_extractor.h"
#include "core/images/exif.h"
#include "mapping/photo_set.h"

namespace cairn {

// A photo that could be read.
struct ReadPhotoResult {
  ExifInfo exif;
  bool has_exif = false;  // Otherwise the orientation is not known.
  // Of the picture in whose pixels the keypoints lie: the stored one.
  int width_px = 0, height_px = 0;
  std::vector<Keypoint> keypoints;
  ByteDescriptorMatrix descriptors;
};

// Decodes a photo and extracts its features. Throws Error(kBadInput), whose message is a reason to
// leave the photo out, as DecodeGrayImage does, and if the photo has fewer than `kMinFeatures`.
ReadPhotoResult ReadMappingPhoto(std::span<const uint8_t> bytes, const FeatureExtractor& extractor);

// A blank or blurred photo. No pose can be told from fewer.
inline constexpr int kMinFeatures = 20;

// A photo as a file of the work folder: docs/formats/mapping_work_v2.md.
std::vector<uint8_t> EncodeReadPhoto(const ReadPhotoResult& photo);
// Throws Error(kMapDamaged), beginning with `what`, if the bytes are no photo whose descriptors
// have this length.
ReadPhotoResult DecodeReadPhoto(std::span<const uint8_t> bytes, int descriptor_dim,
                                const std::string& what);

}  // namespace cairn

#endif  // CAIRN_MAPPING_PHOTOS_READ_PHOTO_H_
