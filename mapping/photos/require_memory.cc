#include "mapping/photos/require_memory.h"

#include <fmt/format.h>

#include "core/error.h"

namespace cairn {
namespace {

// Measured for 1,000 photos of one wall; 300 photos along a street take 600 (docs/figures.md).
constexpr double kBytesOfKeypoint = 660.0;

constexpr double kBytesOfGb = 1e9;

}  // namespace

void RequireMemory(const ReadShare& photos, uint64_t available_bytes) {
  const double needed_bytes = kBytesOfKeypoint * static_cast<double>(photos.num_keypoints);
  if (needed_bytes > static_cast<double>(available_bytes)) {
    throw Error(
        ErrorCode::kBadInput,
        fmt::format("mapping {} of the {} photos, which have {} keypoints, takes about "
                    "{:.1f} GB of memory, more than the {:.1f} GB that the machine or its "
                    "limits leave. Map the photos in parts, one after the other: each is a "
                    "session of its own, which joins the others in the map. Or take fewer "
                    "keypoints of a photo, with mapping.sift.max_features in --options",
                    photos.num_read, photos.num_photos, photos.num_keypoints,
                    needed_bytes / kBytesOfGb, static_cast<double>(available_bytes) / kBytesOfGb));
  }
}

}  // namespace cairn
