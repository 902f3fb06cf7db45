#include "mapping/photos/require_memory.h"

#include <fmt/format.h>

#include "core/error.h"

namespace cairn {
namespace {

// Measured for 1,000 photos of one wall; 300 photos along a street take 600 (docs/figures.md).
constexpr double kBytesOfKeypoint = 660.0;
constexpr double kBytesOfDescriptor = 128.0;  // Of these.

constexpr double kBytesOfGb = 1e9;

}  // namespace

void RequireMemory(const ReadShare& photos, uint64_t available_bytes) {
  const auto num_keypoints = static_cast<double>(photos.num_keypoints);
  const auto available = static_cast<double>(available_bytes);
  const double bytes_of_keypoint =
      kBytesOfKeypoint - (photos.has_descriptors_on_disk ? kBytesOfDescriptor : 0.0);
  if (bytes_of_keypoint * num_keypoints <= available) {
    return;
  }
  const double keypoints_of_photo = num_keypoints / photos.num_read;
  throw Error(
      ErrorCode::kBadInput,
      fmt::format("mapping {} photos with some {:.0f} keypoints each takes about {:.1f} GB of "
                  "memory, and the machine or its limits leave {:.1f} GB. Map the photos in parts, "
                  "one after the other: each is a session of its own, which joins the others in "
                  "the map. Or take fewer keypoints of a photo, with mapping.sift.max_features in "
                  "--options",
                  photos.num_photos, keypoints_of_photo,
                  bytes_of_keypoint * keypoints_of_photo * photos.num_photos / kBytesOfGb,
                  available / kBytesOfGb));
}

}  // namespace cairn
