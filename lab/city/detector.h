// Simulates a feature detector: finds the landmarks of the city that one image shows.
#ifndef CAIRN_LAB_CITY_DETECTOR_H_
#define CAIRN_LAB_CITY_DETECTOR_H_

#include <cstdint>
#include <vector>

#include "core/camera.h"
#include "core/features.h"
#include "core/rigid3.h"
#include "lab/city/city_region.h"
#include "lab/descriptors/descriptor_model.h"

namespace cairn {

struct DetectorOptions {
  double max_range_m = 60.0;  // (0, 300]
  // Largest angle between the surface's normal and the direction to the camera, radians, (0, 1.5].
  // Beyond 60 degrees SIFT rarely finds a point again.
  double max_view_angle_rad = 1.2;
  double min_scale_px = 1.0;   // [0.3, 20]
  double max_scale_px = 30.0;  // Must exceed min_scale_px; at most 200.
  int max_keypoints = 800;     // The strongest are kept. [1, 20000]
  // Standard deviation of a keypoint's position, in units of KeypointSigmaPx (half a pixel for
  // small keypoints, a fifth of the scale for large ones). [0, 20]
  double position_noise = 1.0;
  double log_scale_sigma = 0.12;        // Standard deviation of log(scale), [0, 2].
  double orientation_sigma_rad = 0.12;  // Standard deviation, [0, 3].
  // Share of the keypoints whose orientation is that of another peak of the gradients, [0, 1].
  double other_orientation_share = 0.1;
  // Standard deviation of the random value that each look adds to a landmark's salience, [0, 10].
  // The detector finds the landmark if the sum is positive.
  double response_noise = 0.8;
  // Share of the directions around the camera that people and vehicles occupy, [0, 1]. They hide
  // everything that is not above the horizon.
  double crowd_share = 0.12;

  // Throws Error(kInvalidArgument) that names the field.
  void Validate() const;
};

// One keypoint and the landmark that it shows.
struct Detection {
  const CityLandmark* landmark = nullptr;  // In the region.
  Keypoint keypoint;                       // With noise.
  DescriptorLook look;  // All fields but the appearance mode, which is the image's.
  double range_m = 0.0;
};

// Returns the detections from the strongest to the weakest. A landmark is found if it is in the
// image, near, large, frontal and salient enough, and not hidden. `region` must reach max_range_m
// around the camera.
//
// `image_id` names the image and determines all noise. Images of one rig at one moment share their
// `place_id`, and thereby see the same crowd.
std::vector<Detection> DetectLandmarks(const CityRegion& region, const Camera& camera,
                                       const Rigid3d& cam_from_site, const DetectorOptions& options,
                                       uint64_t image_id, uint64_t place_id);

}  // namespace cairn

#endif  // CAIRN_LAB_CITY_DETECTOR_H_
