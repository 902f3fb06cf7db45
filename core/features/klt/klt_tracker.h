// Tracks corners from image to image (Lucas and Kanade 1981; Shi and Tomasi 1994) with OpenCV.
#ifndef CAIRN_CORE_FEATURES_KLT_KLT_TRACKER_H_
#define CAIRN_CORE_FEATURES_KLT_KLT_TRACKER_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "core/features/tracked_feature.h"

namespace cairn::fusion {

// An 8-bit gray image. The caller owns the memory.
struct GrayView {
  const uint8_t* pixels = nullptr;
  int width_px = 0;
  int height_px = 0;
  ptrdiff_t stride_bytes = 0;  // Distance between the starts of two rows.
};

struct KltOptions {
  int max_features = 200;
  int window_px = 21;  // Side of the compared patch; odd.

  // Throws Error(kInvalidArgument) that names the field.
  void Validate() const;
};

// Not thread-safe. Deterministic.
class KltTracker {
 public:
  // Throws the errors of KltOptions::Validate.
  explicit KltTracker(const KltOptions& options);
  ~KltTracker();

  // Returns the features of the next image, for FusionClient::AddFrame. Features of the previous
  // image that were found again come first and keep their ids; new features follow. Ids are never
  // reused. Pixels follow the project's convention: (0.5, 0.5) is the center of the upper left
  // pixel. The result is valid until the next call.
  //
  // The first image, and an image of a different size, starts with new features only. Throws
  // Error(kBadInput) if `image` is not an image of at least window_px + 8 pixels on each side.
  std::span<const TrackedFeature> Track(const GrayView& image);

  // Forgets all features, for example after the camera has paused.
  void Reset();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cairn::fusion

#endif  // CAIRN_CORE_FEATURES_KLT_KLT_TRACKER_H_
