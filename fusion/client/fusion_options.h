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
  double min_interval_s = 1.0;  // Between queries.
  int max_pending = 4;          // Each keeps one clone and costs the filter its six columns.
  double timeout_s = 6.0;       // After which a query's clone is given up.
  int min_features = 20;        // A frame with fewer is not worth a query.

  void Validate() const;
};

struct FusionOptions {
  Camera camera;
  Rig rig;
  ImuNoise imu_noise;
  double gravity_m_s2 = 9.81;

  int max_clones = 11;    // Of the sliding window; in [3, 16].
  int max_tracks = 1024;  // Features followed at a time.
  // Longest gap between inertial samples that is bridged; a longer one loses the track of local.
  double max_imu_gap_s = 0.3;
  // Coasting begins this long after the last answer that went in.
  double coasting_after_s = 5.0;
  // Fastest at which a correction of the position or yaw of `local` by the map is passed on, so
  // that local_from_imu never jumps.
  double max_slew_m_per_frame = 0.01;
  double max_slew_rad_per_frame = 0.002;
  SteadyPoseOptions steady;  // Of Estimate::steady_global_from_imu.

  FilterStateOptions state;
  // Above it, per axis, the velocity is not known well enough for tracks to be of use; the track of
  // local is lost and a new start is looked for.
  double max_velocity_sigma_m_s = 2.0;
  StandstillOptions standstill;
  RotationOnlyOptions rotation_only;
  StartPrior start;
  DynamicStartOptions dynamic_start;
  TrackUpdateOptions tracks;
  MapUpdateOptions map;
  AlignmentOptions alignment;
  QueryOptions query;

  // Throws Error(kInvalidArgument) naming what makes no sense.
  void Validate() const;
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_CLIENT_FUSION_OPTIONS_H_
