// Brings a reconstruction into the frame of a map that holds some of its images.
#ifndef CAIRN_EVAL_REFERENCE_ALIGNMENT_H_
#define CAIRN_EVAL_REFERENCE_ALIGNMENT_H_

#include <optional>
#include <vector>

#include "core/rigid3.h"
#include "ingest/sfm/reconstruction.h"
#include "storage/map/map_store.h"

namespace cairn {

struct ReferenceAlignment {
  Sim3d ecef_from_world;
  int num_shared_images = 0;
  // How far camera centres and directions of the shared images are apart after alignment.
  double median_residual_m = 0.0;
  double max_residual_m = 0.0;
  double max_residual_rad = 0.0;
};

// Aligns by the poses of the images that reconstruction and map share by name. A map made from a
// part of a reconstruction fits it without residual; that makes the rest of the reconstruction an
// exact reference, whatever the error of the positions the map was placed by. Rotations fix the
// orientation, so cameras along a line are enough. Nothing if fewer than three images are shared or
// their centres coincide. Keyframes with a name that occurs twice do not count.
std::optional<ReferenceAlignment> AlignToKeyframes(const Reconstruction& reconstruction,
                                                   const std::vector<KeyframeRecord>& keyframes);

}  // namespace cairn

#endif  // CAIRN_EVAL_REFERENCE_ALIGNMENT_H_
