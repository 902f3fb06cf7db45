// Options of the sliding-window bundle adjustment.
#ifndef CAIRN_LAB_RIVALS_FUSION_BUNDLE_ADJUSTER_OPTIONS_H_
#define CAIRN_LAB_RIVALS_FUSION_BUNDLE_ADJUSTER_OPTIONS_H_

#include "core/camera.h"
#include "fusion/filter/filter_state.h"
#include "fusion/filter/imu.h"
#include "fusion/tracks/triangulate.h"

namespace cairn::fusion {

// What happens to a camera that leaves the window.
enum class DiscardPolicy {
  kDiscard,      // The furthest from the newest goes, with its residuals (Middelberg et al. 2014).
  kMarginalize,  // The oldest goes; what it said about the others becomes a prior.
};

struct BundleAdjusterOptions {
  Camera camera;
  Rig rig;  // Taken as exact.
  ImuNoise imu_noise;
  double gravity_m_s2 = 9.81;

  DiscardPolicy discard = DiscardPolicy::kDiscard;
  int num_cameras = 10;     // Of the window, at least 3; the paper's variants have 10 and 5.
  int num_iterations = 10;  // Of Levenberg-Marquardt, exactly; the paper's variants have 10, 5, 2.

  double track_sigma_px = 1.0;  // Standard deviation of a tracked pixel per axis.
  double match_sigma_px = 1.0;  // The same of the pixel of a match to the map.
  // Residuals beyond this many standard deviations count linearly (Huber).
  double huber_sigmas = 2.5;
  // Matches to the map whose residual at the prediction is larger are left out; the window has no
  // covariance to gate with.
  double match_gate_px = 20.0;
  // Landmarks of the window whose root mean square residual after optimisation is larger are
  // forgotten.
  double track_gate_sigmas = 3.0;
  int min_views = 3;           // Of a track that takes part.
  int max_local_tracks = 100;  // That take part, the longest first; bounds the time.
  TriangulateOptions triangulate;

  // With kDiscard, biases forgotten with the discarded cameras are held near their last estimate,
  // and position and heading of the oldest camera, which nothing else determines, where they are.
  double gyro_bias_sigma_rad_s = 1e-3;
  double accel_bias_sigma_m_s2 = 2e-2;
  double gauge_sigma_rad = 1e-4;
  double gauge_sigma_m = 1e-3;

  // Biases may move this far before the samples are integrated anew.
  double max_gyro_bias_change_rad_s = 5e-3;
  double max_accel_bias_change_m_s2 = 5e-2;

  // Throws Error(kInvalidArgument) naming what makes no sense.
  void Validate() const;
};

}  // namespace cairn::fusion

#endif  // CAIRN_LAB_RIVALS_FUSION_BUNDLE_ADJUSTER_OPTIONS_H_
