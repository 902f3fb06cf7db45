// Options of the sliding-window bundle adjustment.
#ifndef CAIRN_LAB_RIVALS_FUSION_BUNDLE_ADJUSTER_OPTIONS_H_
#define CAIRN_LAB_RIVALS_FUSION_BUNDLE_ADJUSTER_OPTIONS_H_

#include "core/camera.h"
#include "core/inertial/imu.h"
#include "fusion/filter/filter_state.h"
#include "fusion/tracks/triangulate.h"

namespace cairn::fusion {

// The treatment of a camera that leaves the window.
enum class DiscardPolicy {
  // The camera furthest from the newest goes, with its residuals (Middelberg et al. 2014).
  kDiscard,
  kMarginalize,  // The oldest camera goes; its information becomes a prior.
};

struct BundleAdjusterOptions {
  Camera camera;
  Rig rig;  // Assumed to be exact.
  ImuNoise imu_noise;
  double gravity_m_s2 = 9.81;

  DiscardPolicy discard = DiscardPolicy::kDiscard;
  int num_cameras = 10;  // Window size, at least 3; the paper's variants have 10 and 5.
  // Exact number of Levenberg-Marquardt iterations; the paper's variants have 10, 5 and 2.
  int num_iterations = 10;

  double track_sigma_px = 1.0;  // Standard deviation of a tracked pixel per axis.
  double match_sigma_px = 1.0;  // Standard deviation of a matched pixel per axis.
  // Residuals beyond this many standard deviations count linearly (Huber).
  double huber_sigmas = 2.5;
  // Largest residual of a match to the map at the prediction; matches above it are left out. The
  // window has no covariance to gate with.
  double match_gate_px = 20.0;
  // Largest root mean square residual of a landmark after an optimization. The window drops
  // landmarks above it.
  double track_gate_sigmas = 3.0;
  int min_views = 3;           // Fewest views of a track that takes part.
  int max_local_tracks = 100;  // Most tracks that take part, longest first; bounds the time.
  TriangulateOptions triangulate;

  // Only for kDiscard. The discarded cameras take their knowledge of the biases with them, so the
  // biases are held near their last estimate. Nothing else determines the position and heading of
  // the oldest camera, so these are held at their values.
  double gyro_bias_sigma_rad_s = 1e-3;
  double accel_bias_sigma_m_s2 = 2e-2;
  double gauge_sigma_rad = 1e-4;
  double gauge_sigma_m = 1e-3;

  // The samples are integrated again if a bias has changed by more than this.
  double max_gyro_bias_change_rad_s = 5e-3;
  double max_accel_bias_change_m_s2 = 5e-2;

  // Throws Error(kInvalidArgument) that names the invalid option.
  void Validate() const;
};

}  // namespace cairn::fusion

#endif  // CAIRN_LAB_RIVALS_FUSION_BUNDLE_ADJUSTER_OPTIONS_H_
