// Real SIFT descriptors of known landmarks from known directions: what the descriptor model is
// fitted on.
#ifndef CAIRN_LAB_DESCRIPTORS_REAL_LOOKS_H_
#define CAIRN_LAB_DESCRIPTORS_REAL_LOOKS_H_

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "core/features.h"
#include "ingest/sfm/reconstruction.h"
#include "lab/street/street_scene.h"

namespace cairn {

// From where a landmark was seen.
struct RealLook {
  int ornament = 0;  // Landmarks of one ornament look alike; otherwise each has its own.
  int landmark = 0;
  int image = 0;
  int appearance_mode = 0;  // Photos of one mode were taken on one day by one camera.
  // Of the direction from the landmark to the camera, about the surface's normal where that is
  // known and about the direction of the landmark's first look where not.
  float azimuth_rad = 0.0f;
  float elevation_rad = 0.0f;
  float log2_scale = 0.0f;  // Of focal length over depth: pixels a metre.
};

// Looks of an ornament are consecutive; looks[i] belongs to root.row(i).
struct RealLooks {
  std::vector<RealLook> looks;
  DescriptorMatrix root;  // RootSIFT.

  int size() const { return static_cast<int>(looks.size()); }
};

// Which keypoint of an image is taken for a look at a landmark: the one nearest to where geometry
// says that it appears, whatever its descriptor. Matchers keep pairs that look alike, and so hide
// how much looks differ.
struct RealLooksOptions {
  double max_distance_px = 1.5;
  double max_log2_size_ratio = 0.5;   // Of physical keypoint sizes.
  double max_orientation_rad = 0.35;  // From what geometry says.
  int max_landmarks = 5'000;          // Evenly picked.
  // Added to where geometry says: with many pixels, keypoints that are there by chance are
  // measured.
  Eigen::Vector2d offset_px = Eigen::Vector2d::Zero();

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

// Of a reconstruction from upright cameras: orientations in images are taken to be the same from
// everywhere. A landmark's first look is its first observation.
RealLooks LooksAtReconstruction(const Reconstruction& reconstruction,
                                const RealLooksOptions& options = {});

// Of photos of one facade by different cameras on different days: each pair of photos of which a
// homography explains a good part. Every landmark has two looks; the first has azimuth, elevation
// and scale 0, the azimuth of the second is the angle by which a disc must be tilted to look as it
// does there. `max_landmarks` holds for each pair.
RealLooks LooksAtFacade(const std::vector<GrayImage>& photos, const RealLooksOptions& options = {});

// Of the rendered street: photos as the demo takes them for mapping and for queries. Landmarks are
// keypoints of mapping photos, placed by casting a ray. Takes half a minute.
RealLooks LooksAtStreet(const StreetOptions& street, const RealLooksOptions& options = {});

// What repeats on the rendered street's facades. An ornament has two landmarks, each seen once and
// in the same photo: keypoints at the same height of the same front, of the same size and
// orientation, half a metre or more apart. Half are windows and what belongs to them, the others
// strangers.
RealLooks RepeatsOnStreet(const StreetOptions& street);

}  // namespace cairn

#endif  // CAIRN_LAB_DESCRIPTORS_REAL_LOOKS_H_
