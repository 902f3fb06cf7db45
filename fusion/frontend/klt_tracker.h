// Follows corners from image to image (Lucas and Kanade 1981; Shi and Tomasi 1994), by OpenCV.
#ifndef CAIRN_FUSION_FRONTEND_KLT_TRACKER_H_
#define CAIRN_FUSION_FRONTEND_KLT_TRACKER_H_

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "fusion/tracks/track_table.h"

namespace cairn::fusion {

// An 8-bit grey image in someone else's memory.
struct GrayView {
  const uint8_t* pixels = nullptr;
  int width_px = 0;
  int height_px = 0;
  ptrdiff_t stride_bytes = 0;  // From row to row.
};

struct KltOptions {
  int max_features = 200;
  int grid_columns = 8;  // New corners fill the cells of a grid evenly, so that features cover the
  int grid_rows = 6;     // image even if one part of it has most of the texture.
  double min_distance_px = 10.0;  // Between features.
  // Of a new corner: smaller eigenvalue of the gradient's structure tensor relative to the best
  // one's. Low, as dim cells need corners, too; tracking sorts out bad ones.
  double min_relative_quality = 0.003;
  int window_px = 21;  // Side of the patch that is compared; odd.
  int num_levels = 4;  // Of the pyramid: motions up to some 2^num_levels * window_px / 4.
  int max_iterations = 30;
  // Tracked to the new image and back, a feature must come this near to where it was.
  double max_forward_backward_px = 0.5;
  int border_px = 4;  // Features nearer to the edge of the image are given up.

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

// Not thread-safe. Deterministic.
class KltTracker {
 public:
  // Throws as KltOptions::Validate.
  explicit KltTracker(const KltOptions& options);
  ~KltTracker();

  // The features of the next image, for FusionClient::AddFrame: those of the image before that were
  // found again under their ids, then new ones. Pixels with the project's convention, (0.5, 0.5)
  // the centre of the upper left one. Valid until the next call. The first image, or one of another
  // size, starts anew; ids are never used twice. Throws Error(kBadInput) if the view is not an
  // image of at least 2 * border_px + window_px on a side.
  std::span<const TrackedFeature> Track(const GrayView& image);

  // Forgets all features, e.g. after a pause of the camera.
  void Reset();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_FRONTEND_KLT_TRACKER_H_
