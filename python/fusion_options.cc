#include "python/fusion_options.h"

#include "cli/options/read_options.h"
#include "core/error.h"
#include "python/arguments.h"

namespace cairn::python {
namespace {

void DescribeNoise(fusion::ImuNoise* noise, OptionList* list) {
  list->Add("gyro_density", &noise->gyro_density, "rad / s / sqrt(Hz)");
  list->Add("accel_density", &noise->accel_density, "m / s^2 / sqrt(Hz)");
  list->Add("gyro_walk", &noise->gyro_walk, "Random walk of the bias, rad / s^2 / sqrt(Hz)");
  list->Add("accel_walk", &noise->accel_walk, "Random walk of the bias, m / s^3 / sqrt(Hz)");
}

void DescribeState(fusion::FilterStateOptions* state, OptionList* list) {
  list->Add("extrinsic_rotation_sigma_rad", &state->extrinsic_rotation_sigma_rad,
            "Standard deviation of the rotation of cam_from_imu; 0 takes it as exact");
  list->Add("extrinsic_translation_sigma_m", &state->extrinsic_translation_sigma_m,
            "Standard deviation of the translation of cam_from_imu; 0 takes it as exact");
  list->Add("time_offset_sigma_s", &state->time_offset_sigma_s,
            "Standard deviation of the time offset; 0 takes it as exact");
  list->Add("tile_sigma_m", &state->tile_sigma_m, "Of an offset that a tile's landmarks share");
  list->Add("max_points", &state->max_points, "Most tracked points in the state");
}

void DescribeQuery(fusion::QueryOptions* query, OptionList* list) {
  list->Add("min_interval_s", &query->min_interval_s, "Shortest time between two queries");
  list->Add("max_pending", &query->max_pending, "Most queries without an answer");
  list->Add("timeout_s", &query->timeout_s, "An answer that takes longer is dropped");
}

void DescribeStandstill(fusion::StandstillOptions* standstill, OptionList* list) {
  list->Add("window_s", &standstill->window_s, "Length of the past that must be quiet");
  list->Add("max_gyro_std_rad_s", &standstill->max_gyro_std_rad_s, "Most noise at rest");
  list->Add("max_accel_std_m_s2", &standstill->max_accel_std_m_s2, "Most noise at rest");
}

OptionList Describe(fusion::FusionOptions* options) {
  OptionList list("Options of the filter");
  list.Add("gravity_m_s2", &options->gravity_m_s2, "Gravity at the place");
  list.Add("time_offset_s", &options->rig.time_offset_s,
           "IMU time minus camera time, for the same instant");
  list.Add("max_clones", &options->max_clones, "Length of the sliding window, frames");
  list.AddSection("imu_noise", "Noise of the inertial unit",
                  [&] { DescribeNoise(&options->imu_noise, &list); });
  list.AddSection("state", "What is estimated", [&] { DescribeState(&options->state, &list); });
  list.AddSection("query", "When the map is asked", [&] { DescribeQuery(&options->query, &list); });
  list.AddSection("standstill", "When the device rests",
                  [&] { DescribeStandstill(&options->standstill, &list); });
  list.AddSection("tracks", "Tracked features", [&] {
    list.Add("sigma_px", &options->tracks.sigma_px, "Standard deviation of a tracked pixel");
    list.Add("max_tracks", &options->tracks.max_tracks, "Most tracks of an update");
  });
  list.AddSection("map", "Answers of the map", [&] {
    list.Add("sigma_px", &options->map.sigma_px, "Standard deviation of a matched keypoint");
    list.Add("tilt_sigma_rad", &options->map.tilt_sigma_rad, "Of the tilt between the frames");
  });
  list.AddSection("steady", "Smoothing of the pose to show", [&] {
    list.Add("time_constant_s", &options->steady.time_constant_s, "0 smooths nothing");
    list.Add("max_held_back_m", &options->steady.max_held_back_m, "Larger corrections jump");
    list.Add("max_held_back_rad", &options->steady.max_held_back_rad, "Larger corrections jump");
  });
  return list;
}

}  // namespace

void SetFusionOptions(py::handle value, fusion::FusionOptions* options) {
  if (value.is_none()) {
    return;
  }
  const std::string json = OptionsJsonOf(value);
  OptionList list = Describe(options);
  try {
    ReadOptions(json, &list);
  } catch (const Error& error) {
    throw Error(error.code(), std::string("options: ") + error.what());
  }
}

}  // namespace cairn::python
