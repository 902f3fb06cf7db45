#include "mapping/photos/require_memory.h"

#include <fmt/format.h>

#include "core/error.h"

namespace cairn {
namespace {

// Measured: 600 for 300 photos along a street, 660 for 1,000 photos of one wall (docs/figures.md).
constexpr double kBytesOfKeypoint = 600.0;

constexpr int kLeastRead = 100;
constexpr double kBytesOfGb = 1e9;

}  // namespace

void RequireMemory(const ReadShare& photos, uint64_t available_bytes) {
  if (photos.num_read < kLeastRead) {
    return;
  }
  const double keypoints_of_photo = static_cast<double>(photos.num_keypoints) / photos.num_read;
  const double needed_bytes = kBytesOfKeypoint * keypoints_of_photo * photos.num_photos;
  if (needed_bytes > static_cast<double>(available_bytes)) {
    throw Error(
        ErrorCode::kUnavailable,
        fmt::format("mapping {} photos with some {:.0f} keypoints each takes about {:.1f} GB of "
                    "memory, and {:.1f} GB are free. Map the photos in parts, one after the other: "
                    "each is a session of its own, which meets the others in the map. Or take "
                    "fewer keypoints of a photo, with mapping.sift.max_features in --options",
                    photos.num_photos, keypoints_of_photo, needed_bytes / kBytesOfGb,
                    static_cast<double>(available_bytes) / kBytesOfGb));
  }
}

}  // namespace cairn
