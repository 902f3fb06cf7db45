// What a feature detector finds of the city in one image.
#ifndef CAIRN_LAB_CITY_CAMERAS_DETECTOR_H_
#define CAIRN_LAB_CITY_CAMERAS_DETECTOR_H_

#include <cstdint>
#include <vector>

#include "core/camera.h"
#include "core/features.h"
#include "core/rigid3.h"
#include "lab/city/geometry/city_region.h"
#include "lab/descriptors/descriptor_model.h"

namespace cairn {

struct DetectorOptions {
  double max_range_m = 60.0;  // (0, 300]
  // Between the surface's normal and the direction to the camera, radians, (0, 1.5]: SIFT hardly
  // finds a point again beyond 60 degrees.
  double max_view_angle_rad = 1.2;
  double min_scale_px = 1.0;   // [0.3, 20]
  double max_scale_px = 30.0;  // Above min_scale_px, at most 200.
  int max_keypoints = 800;     // The strongest. [1, 20000]
  // Standard deviations of a keypoint's place, in units of KeypointSigmaPx (half a pixel for small
  // keypoints, a fifth of the scale for large ones), [0, 20];
  double position_noise = 1.0;
  double log_scale_sigma = 0.12;        // of its scale's logarithm, [0, 2];
  double orientation_sigma_rad = 0.12;  // and of its orientation, [0, 3].
  // Of the keypoints, whose orientation is that of another peak of the gradients: [0, 1].
  double other_orientation_share = 0.1;
  // Standard deviation of what a look adds to the salience of a landmark, [0, 10]; landmarks are
  // found if the sum is positive.
  double response_noise = 0.8;
  // Of the directions around the camera in which people and vehicles stand, [0, 1]; they hide what
  // is not above the horizon.
  double crowd_share = 0.12;

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;
};

// One keypoint and what it is of.
struct Sighting {
  const CityLandmark* landmark = nullptr;  // Of the region.
  Keypoint keypoint;                       // Noisy.
  DescriptorLook look;  // All but the appearance mode, which is that of the image.
  double range_m = 0.0;
};

// From the strongest to the weakest. A landmark is found if it is in the image, near, large and
// frontal enough, salient, and not hidden. `image_id` names the image: all noise depends on it;
// `place_id` is shared by the images of one rig at one moment: they see the same crowd.
// `region` must reach max_range_m about the camera.
std::vector<Sighting> DetectLandmarks(const CityRegion& region, const Camera& camera,
                                      const Rigid3d& cam_from_site, const DetectorOptions& options,
                                      uint64_t image_id, uint64_t place_id);

}  // namespace cairn

#endif  // CAIRN_LAB_CITY_CAMERAS_DETECTOR_H_
