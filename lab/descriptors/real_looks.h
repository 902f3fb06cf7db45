// Real SIFT descriptors of known landmarks from known directions. The descriptor model is fitted to
// them.
#ifndef CAIRN_LAB_DESCRIPTORS_REAL_LOOKS_H_
#define CAIRN_LAB_DESCRIPTORS_REAL_LOOKS_H_

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "cli/demo/street/street_scene.h"
#include "core/features.h"
#include "core/scene/reconstruction.h"

namespace cairn {

// The view from which a landmark was seen.
struct RealLook {
  // Landmarks of one ornament look alike. A landmark that resembles no other has an ornament of its
  // own.
  int ornament = 0;
  int landmark = 0;
  int image = 0;
  int appearance_mode = 0;  // One mode: one day and one camera.
  // Direction from the landmark to the camera. Measured from the surface's normal if that is known,
  // otherwise from the direction of the landmark's first look.
  float azimuth_rad = 0.0f;
  float elevation_rad = 0.0f;
  float log2_scale = 0.0f;  // log2 of focal length over depth (pixels per meter).
};

// The looks at an ornament are consecutive. looks[i] belongs to root.row(i).
struct RealLooks {
  std::vector<RealLook> looks;
  DescriptorMatrix root;  // RootSIFT.

  int size() const { return static_cast<int>(looks.size()); }
};

// Rules that assign keypoints of an image to a landmark. The keypoint nearest to the position that
// geometry predicts is the look, whatever its descriptor. Matchers are not used, because they keep
// pairs that look alike and thereby hide how much looks differ.
struct RealLooksOptions {
  double max_distance_px = 1.5;
  double max_log2_size_ratio = 0.5;   // Ratio of physical keypoint sizes.
  double max_orientation_rad = 0.35;  // Difference to the predicted orientation.
  int max_landmarks = 5'000;          // Evenly picked.
  // Added to the predicted position. An offset of many pixels measures keypoints that are there by
  // chance.
  Eigen::Vector2d offset_px = Eigen::Vector2d::Zero();

  // Throws Error(kInvalidArgument) that names the field.
  void Validate() const;
};

// Returns looks from a reconstruction with upright cameras. Assumes that a keypoint's orientation
// is the same in all images. A landmark's first look is its first observation.
RealLooks LooksAtReconstruction(const Reconstruction& reconstruction,
                                const RealLooksOptions& options = {});

// Returns looks from photos of one facade by different cameras on different days. Uses each pair of
// photos of which a homography explains a good part. Every landmark has two looks. The first has
// azimuth, elevation and scale 0. The azimuth of the second is the tilt at which a disk looks as it
// does in the second photo. `max_landmarks` applies to each pair.
RealLooks LooksAtFacade(const std::vector<GrayImage>& photos, const RealLooksOptions& options = {});

// Returns looks from the rendered street, photographed like the demo's mapping and query photos.
// Landmarks are keypoints of mapping photos, located by casting a ray. Takes half a minute.
RealLooks LooksAtStreet(const StreetOptions& street, const RealLooksOptions& options = {});

// Returns repetitions on the rendered street's facades. An ornament has two landmarks, each with
// one look in the same photo. The two keypoints have the same height on the same front, the same
// size and orientation, and are at least half a meter apart. Half of the ornaments are windows and
// their parts; the others are unrelated.
RealLooks RepeatsOnStreet(const StreetOptions& street);

}  // namespace cairn

#endif  // CAIRN_LAB_DESCRIPTORS_REAL_LOOKS_H_
