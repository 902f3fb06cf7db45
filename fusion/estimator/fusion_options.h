// All options of the client library.
#ifndef CAIRN_FUSION_ESTIMATOR_FUSION_OPTIONS_H_
#define CAIRN_FUSION_ESTIMATOR_FUSION_OPTIONS_H_

#include "core/camera.h"
#include "core/inertial/imu.h"
#include "core/rigid3.h"
#include "fusion/estimator/steady_pose.h"
#include "fusion/filter/filter_state.h"
#include "fusion/map_updates/map_update.h"
#include "fusion/start/dynamic_start.h"
#include "fusion/start/standstill.h"
#include "fusion/tracks/track_update.h"

namespace cairn::fusion {

struct QueryOptions {
  double min_interval_s = 1.0;  // Shortest time between two queries.
  int max_pending = 4;          // Each pending query keeps a clone: six columns.
  double timeout_s = 6.0;       // A query's clone is released after this time.

  void Validate() const;
};

struct FusionOptions {
  Camera camera;
  Rig rig;
  ImuNoise imu_noise;
  double gravity_m_s2 = 9.81;

  int max_clones = 11;       // Length of the sliding window; in [3, 16].
  SteadyPoseOptions steady;  // Smoothing of Estimate::steady_global_from_imu.

  FilterStateOptions state;
  StandstillOptions standstill;
  DynamicStartOptions dynamic_start;
  TrackUpdateOptions tracks;
  MapUpdateOptions map;
  QueryOptions query;

  // Throws Error(kInvalidArgument) that names the invalid option.
  void Validate() const;
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_ESTIMATOR_FUSION_OPTIONS_H_
