// Compares the filter with bundle adjustment on one recording: the paper's table on the cost and
// accuracy of updates by global matches, and its figure on smoothness ("Evaluation of the Pose
// Fusion").
#ifndef CAIRN_LAB_RIVALS_FUSION_COMPARISON_H_
#define CAIRN_LAB_RIVALS_FUSION_COMPARISON_H_

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "eval/recordings/recording.h"
#include "lab/rivals/fusion/bundle_adjuster_options.h"

namespace cairn::fusion {

// Statistics of positive numbers.
struct Spread {
  double mean = 0.0;
  double standard_deviation = 0.0;
};

struct Smoothness {
  double rms = 0.0;
  double percentile_95 = 0.0;
  double maximum = 0.0;
};

// The results of one estimator.
struct MethodResult {
  // "EKF" or "BA-10-5", for example. "-M" marks marginalization, "-F" that every frame is a
  // keyframe. ", steady" marks the poses that a display would show.
  std::string name;
  bool is_steady = false;
  size_t num_counted_frames = 0;
  double position_rmse_m = 0.0;
  double rotation_rmse_rad = 0.0;
  Spread position_error_m;  // Over the frames, as in the paper's table.
  Spread rotation_error_rad;
  // Change of the error from frame to frame, with the error in global: |e_k - e_k-1| and |Log(E_k
  // E_k-1')|.
  Smoothness position_change_m;
  Smoothness rotation_change_rad;
  // CPU time of one thread over the counted frames, without propagation and preintegration.
  Spread update_seconds;      // The update by an answer; see CompareEstimators.
  Spread frame_seconds;       // All work for a frame that comes with an answer.
  double mean_matches = 0.0;  // Per update.
};

// One bundle adjustment in the table.
struct RivalVariant {
  int num_cameras = 10;
  int num_iterations = 10;
  DiscardPolicy discard = DiscardPolicy::kDiscard;
  // If true, the window holds the latest frames one by one, like the filter's window, instead of
  // the queried frames.
  bool every_frame_is_keyframe = false;

  std::string Name() const;
};

// The paper's variants: BA-10-10, BA-10-5, BA-5-10, BA-5-5 and BA-5-2; then BA-10-5 and BA-5-2 with
// marginalization.
std::vector<RivalVariant> PaperVariants();

// Returns the options that all variants share with the filter on a recording: camera, rig, noise
// and gravity.
BundleAdjusterOptions RivalOptions(const Recording& recording, const RivalVariant& variant);

struct ComparisonOptions {
  std::vector<RivalVariant> variants = PaperVariants();
  // Number of runs over the recording. Each frame's time is that of its fastest run. The estimates
  // are those of the first run.
  int num_timings = 1;
  // If true, the rivals' poses are also smoothed. The results are additional rows after all others.
  bool steadies_rivals = false;

  // Throws Error(kInvalidArgument) that names the invalid option.
  void Validate() const;
};

// Runs all estimators on the same samples, tracks, answers and noise. Each answer reaches the
// estimators one frame after its query. The results are, in order: the filter; the poses that the
// filter publishes for displays (Estimate::steady_global_from_imu, with the filter's times); each
// variant.
//
// The time of an update has a different meaning for each kind of estimator. For a rival, it covers
// gating the matches, building the problem and solving it. For the filter, it covers gating,
// compressing and applying all matches of the answer on a copy of its state. A comparison of the
// filter's frames with and without an answer would not do: observations that go into the answer are
// not used as tracks, so a frame with an answer may cost less. `frame_seconds` is the filter's
// whole frame, including propagation and local tracks.
//
// Throws Error(kBadInput) if a recording has fewer than two counted frames or its samples do not
// span its frames.
std::vector<MethodResult> CompareEstimators(const Recording& recording,
                                            const ComparisonOptions& options);

// Returns the table as text, together with the ratios of the first two results (the filter and its
// steady poses) to the others.
std::string ComparisonTable(const std::string& title, std::span<const MethodResult> results);

}  // namespace cairn::fusion

#endif  // CAIRN_LAB_RIVALS_FUSION_COMPARISON_H_
