// Aligns a reconstruction with a map that contains some of its images.
#ifndef CAIRN_EVAL_REFERENCE_ALIGNMENT_H_
#define CAIRN_EVAL_REFERENCE_ALIGNMENT_H_

#include <optional>
#include <vector>

#include "core/rigid3.h"
#include "core/scene/reconstruction.h"
#include "storage/map/map_store.h"

namespace cairn {

struct ReferenceAlignment {
  Sim3d ecef_from_world;
  int num_shared_images = 0;
  int num_fitting_images = 0;  // Of the shared images: those that the alignment is fitted to.
  // Distances between the camera centers of all shared images after alignment.
  double median_residual_m = 0.0;
  double radius68_m = 0.0;  // 68 % are less: how far the two differ in shape.
  double max_residual_m = 0.0;
  double radius68_rad = 0.0;  // The same of the rotations of the shared images.
  double max_residual_rad = 0.0;
};

// Aligns the reconstruction by the poses of the images that it shares with the map by name. A map
// made from a part of the reconstruction fits without residual. The rest of the reconstruction then
// is an exact reference, independent of the error of the positions that placed the map. Rotations
// fix the orientation, so cameras along a line suffice. A part of the map that stands elsewhere,
// such as a segment with positions of its own, pulls nothing: the fit has the least median of
// distances, and then takes the images within three standard deviations of it. Returns nothing if
// fewer than three images are shared or if their centers coincide. Ignores keyframes whose name
// occurs twice.
std::optional<ReferenceAlignment> AlignToKeyframes(const Reconstruction& reconstruction,
                                                   const std::vector<KeyframeRecord>& keyframes);

}  // namespace cairn

#endif  // CAIRN_EVAL_REFERENCE_ALIGNMENT_H_
