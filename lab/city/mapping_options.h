// Options of the simulated mapping of a city.
#ifndef CAIRN_LAB_CITY_MAPPING_OPTIONS_H_
#define CAIRN_LAB_CITY_MAPPING_OPTIONS_H_

#include <cstdint>

#include "core/camera.h"
#include "lab/city/detector.h"

namespace cairn {

// The camera rig of the mapping car: `num_cameras` equal cameras in a circle. The first points half
// a camera step to the left of straight ahead.
struct RigOptions {
  int num_cameras = 4;        // [1, 12]
  int image_width_px = 800;   // [64, 8192]
  int image_height_px = 800;  // [64, 8192]
  double focal_px = 420.0;    // [20, 20000]. The default gives four cameras of 87 degrees.
  double height_m = 2.5;      // Above the ground, [0.2, 10].
  double pitch_rad = 0.15;    // Upward, [-1, 1].

  void Validate() const;
  Camera MakeCamera() const;  // A PINHOLE camera.
};

// Errors of the reconstruction and of the GPS, as standard deviations per axis. None may be
// negative.
struct MappingNoise {
  double camera_position_m = 0.02;  // Position of a rig; independent errors.
  double camera_rotation_rad = 4e-4;
  // Drift of each pass against the others, varying over about 100 m: the error that bundle
  // adjustment leaves.
  double pass_drift_m = 0.03;
  // Deformation of the whole map, varying over about 400 m: the error that georegistration leaves.
  double deformation_m = 0.15;
  // Share of the landmark observations that show something else nearby, [0, 0.5].
  double wrong_observation_share = 0.005;
  double gps_m = 3.0;  // GPS position of an image.

  void Validate() const;
};

struct SimulatedMappingOptions {
  int num_passes = 4;               // [1, 1000]
  double years = 2.0;               // From the first pass to the last, [0, 100].
  double keyframe_spacing_m = 5.0;  // Between panoramas of a pass, [0.2, 100].
  double lane_share = 0.7;          // Share of the lanes that each pass drives, (0, 1].
  int num_appearance_modes = 4;     // Kinds of light and season, one per pass. [1, 1000]
  RigOptions rig;
  DetectorOptions detector = {.max_keypoints = 500};
  // Fewest observations of a landmark, [2, 100]. In real maps half of the landmarks have two.
  int min_observations = 2;
  // Matching fails between looks that differ too much, and sometimes between passes. One physical
  // point then becomes several landmarks.
  double track_view_rad = 0.9;   // Range of azimuths of a track, (0, 7].
  double track_octaves = 1.5;    // Range of scales of a track, (0, 20].
  double pass_join_share = 0.6;  // Share of passes that join a common track, [0, 1].
  // Keypoints without a landmark in each image, per keypoint with a landmark, [0, 20]. Maps do not
  // need them, but other tools do.
  double clutter_ratio = 0.0;
  MappingNoise noise;
  uint64_t seed = 1;

  // Throws Error(kInvalidArgument) that names the field.
  void Validate() const;

  // Time of a pass. The first pass is at 0.
  double TimeYears(int pass) const;
  uint32_t AppearanceMode(int pass) const;
};

}  // namespace cairn

#endif  // CAIRN_LAB_CITY_MAPPING_OPTIONS_H_
