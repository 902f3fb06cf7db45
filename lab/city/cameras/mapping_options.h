// How the simulated city is mapped.
#ifndef CAIRN_LAB_CITY_CAMERAS_MAPPING_OPTIONS_H_
#define CAIRN_LAB_CITY_CAMERAS_MAPPING_OPTIONS_H_

#include <cstdint>

#include "core/camera.h"
#include "lab/city/cameras/detector.h"

namespace cairn {

// The camera rig of the car: `num_cameras` equal cameras that look around, the first half a step to
// the left of straight ahead.
struct RigOptions {
  int num_cameras = 4;        // [1, 12]
  int image_width_px = 800;   // [64, 8192]
  int image_height_px = 800;  // [64, 8192]
  double focal_px = 420.0;    // [20, 20000]; four cameras of 87 degrees.
  double height_m = 2.5;      // Above the ground, [0.2, 10].
  double pitch_rad = 0.15;    // Upwards, [-1, 1].

  void Validate() const;
  Camera MakeCamera() const;  // PINHOLE.
};

// Errors of the reconstruction and of the GPS. Standard deviations per axis; none may be negative.
struct MappingNoise {
  double camera_position_m = 0.02;  // Of a rig, independent.
  double camera_rotation_rad = 4e-4;
  // Of each pass against the others, varying over some 100 m: what bundle adjustment leaves.
  double pass_drift_m = 0.03;
  // Of the map as a whole, varying over some 400 m: what georegistration leaves.
  double deformation_m = 0.15;
  // Of the observations of landmarks, that belong to something else nearby: [0, 0.5].
  double wrong_observation_share = 0.005;
  double gps_m = 3.0;  // Of the images' GPS positions.

  void Validate() const;
};

struct MappingOptions {
  int num_passes = 4;               // [1, 1000]
  double years = 2.0;               // From the first pass to the last, [0, 100].
  double keyframe_spacing_m = 5.0;  // Between panoramas of a pass, [0.2, 100].
  double lane_share = 0.7;          // Of the lanes that a pass drives, (0, 1].
  int num_appearance_modes = 4;     // Kinds of light and season; each pass has one. [1, 1000]
  RigOptions rig;
  DetectorOptions detector = {.max_keypoints = 500};
  // Observations that make a landmark, [2, 100]; in real maps half of them have two.
  int min_observations = 2;
  // Matching fails between looks that differ too much, and now and then between passes: one thing
  // becomes several landmarks.
  double track_view_rad = 0.9;   // Range of azimuths of a track, (0, 7].
  double track_octaves = 1.5;    // Range of scales of a track, (0, 20].
  double pass_join_share = 0.6;  // Of the passes, that find a thing the same as others. [0, 1]
  // Keypoints without a landmark in each image, for each one that has a landmark, [0, 20]. Maps do
  // not need them; other tools do.
  double clutter_ratio = 0.0;
  MappingNoise noise;
  uint64_t seed = 1;

  // Throws Error(kInvalidArgument) naming the field.
  void Validate() const;

  // Of a pass; the first is at 0.
  double TimeYears(int pass) const;
  uint32_t AppearanceMode(int pass) const;
};

}  // namespace cairn

#endif  // CAIRN_LAB_CITY_CAMERAS_MAPPING_OPTIONS_H_
