// All options of the client library.
#ifndef CAIRN_FUSION_CLIENT_FUSION_OPTIONS_H_
#define CAIRN_FUSION_CLIENT_FUSION_OPTIONS_H_

#include "core/camera.h"
#include "core/rigid3.h"
#include "fusion/client/steady_pose.h"
#include "fusion/filter/filter_state.h"
#include "fusion/filter/imu.h"
#include "fusion/map_updates/alignment.h"
#include "fusion/map_updates/map_update.h"
#include "fusion/start/dynamic_start.h"
#include "fusion/start/standstill.h"
#include "fusion/tracks/rotation_only.h"
#include "fusion/tracks/track_update.h"

namespace cairn::fusion {

struct QueryOptions {
  double min_interval_s = 1.0;  // Shortest time between two queries.
  int max_pending = 4;          // Each pending query keeps a clone: six columns.
  double timeout_s = 6.0;       // A query's clone is released after this time.
  int min_features = 20;        // A frame with fewer features is not queried.

  void Validate() const;
};

struct FusionOptions {
  Camera camera;
  Rig rig;
  ImuNoise imu_noise;
  double gravity_m_s2 = 9.81;

  int max_clones = 11;    // Length of the sliding window; in [3, 16].
  int max_tracks = 1024;  // Most features tracked at a time.
  // Longest gap between inertial samples that the filter bridges. After a longer gap, `local`
  // starts over.
  double max_imu_gap_s = 0.3;
  // Coasting begins this long after the last applied answer.
  double coasting_after_s = 5.0;
  // Largest change per frame by which a correction of the map moves the position or yaw of `local`.
  // The limits keep local_from_imu free of jumps.
  double max_slew_m_per_frame = 0.01;
  double max_slew_rad_per_frame = 0.002;
  SteadyPoseOptions steady;  // Smoothing of Estimate::steady_global_from_imu.

  FilterStateOptions state;
  // Largest standard deviation of the velocity, per axis. Above it, tracks are of no use: `local`
  // is lost, and the filter looks for a new start.
  double max_velocity_sigma_m_s = 2.0;
  StandstillOptions standstill;
  RotationOnlyOptions rotation_only;
  StartPrior start;
  DynamicStartOptions dynamic_start;
  TrackUpdateOptions tracks;
  MapUpdateOptions map;
  AlignmentOptions alignment;
  QueryOptions query;

  // Throws Error(kInvalidArgument) that names the invalid option.
  void Validate() const;
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_CLIENT_FUSION_OPTIONS_H_
