#include "lab/city/mapping_options.h"

#include "core/require.h"
#include "lab/city/hashed_random.h"

namespace cairn {

void RigOptions::Validate() const {
  RequireWithin("mapping.rig.num_cameras", num_cameras, 1, 12);
  RequireWithin("mapping.rig.image_width_px", image_width_px, 64, 8192);
  RequireWithin("mapping.rig.image_height_px", image_height_px, 64, 8192);
  RequireWithin("mapping.rig.focal_px", focal_px, 20.0, 20'000.0);
  RequireWithin("mapping.rig.height_m", height_m, 0.2, 10.0);
  RequireWithin("mapping.rig.pitch_rad", pitch_rad, -1.0, 1.0);
}

Camera RigOptions::MakeCamera() const {
  return Camera(CameraModel::kPinhole, image_width_px, image_height_px,
                {focal_px, focal_px, 0.5 * image_width_px, 0.5 * image_height_px});
}

void MappingNoise::Validate() const {
  RequireWithin("mapping.noise.camera_position_m", camera_position_m, 0.0, 10.0);
  RequireWithin("mapping.noise.camera_rotation_rad", camera_rotation_rad, 0.0, 0.5);
  RequireWithin("mapping.noise.pass_drift_m", pass_drift_m, 0.0, 10.0);
  RequireWithin("mapping.noise.deformation_m", deformation_m, 0.0, 20.0);
  RequireWithin("mapping.noise.wrong_observation_share", wrong_observation_share, 0.0, 0.5);
  RequireWithin("mapping.noise.gps_m", gps_m, 0.0, 1000.0);
}

void SimulatedMappingOptions::Validate() const {
  RequireWithin("mapping.num_passes", num_passes, 1, 1000);
  RequireWithin("mapping.years", years, 0.0, 100.0);
  RequireWithin("mapping.keyframe_spacing_m", keyframe_spacing_m, 0.2, 100.0);
  RequireWithin("mapping.lane_share", lane_share, 0.01, 1.0);
  RequireWithin("mapping.num_appearance_modes", num_appearance_modes, 1, 1000);
  RequireWithin("mapping.min_observations", min_observations, 2, 100);
  RequireWithin("mapping.track_view_rad", track_view_rad, 0.01, 7.0);
  RequireWithin("mapping.track_octaves", track_octaves, 0.01, 20.0);
  RequireWithin("mapping.pass_join_share", pass_join_share, 0.0, 1.0);
  RequireWithin("mapping.clutter_ratio", clutter_ratio, 0.0, 20.0);
  rig.Validate();
  detector.Validate();
  noise.Validate();
}

double SimulatedMappingOptions::TimeYears(int pass) const {
  return num_passes == 1 ? 0.0 : years * pass / (num_passes - 1);
}

uint32_t SimulatedMappingOptions::AppearanceMode(int pass) const {
  return static_cast<uint32_t>(pass % num_appearance_modes);
}

}  // namespace cairn
