// Whether a folder's photos can be mapped with the memory there is. Private to mapping/photos.
#ifndef CAIRN_MAPPING_PHOTOS_REQUIRE_MEMORY_H_
#define CAIRN_MAPPING_PHOTOS_REQUIRE_MEMORY_H_

#include <cstdint>

namespace cairn {

// Photos of which some were read.
struct ReadShare {
  int num_photos = 0;  // In all.
  int num_read = 0;
  int64_t num_keypoints = 0;  // Of those that were read.
  bool has_descriptors_on_disk = false;
};

// Throws Error(kBadInput) if mapping the photos that were read takes more memory than
// `available_bytes`. The message says what all photos take if the others have as many keypoints.
void RequireMemory(const ReadShare& photos, uint64_t available_bytes);

}  // namespace cairn

#endif  // CAIRN_MAPPING_PHOTOS_REQUIRE_MEMORY_H_
