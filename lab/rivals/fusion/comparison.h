// The filter against bundle adjustment on one recording: the paper's table on the cost and accuracy
// of updates by global matches, and its figure on smoothness ("Evaluation of the Pose Fusion").
#ifndef CAIRN_LAB_RIVALS_FUSION_COMPARISON_H_
#define CAIRN_LAB_RIVALS_FUSION_COMPARISON_H_

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "lab/recordings/recording.h"
#include "lab/rivals/fusion/bundle_adjuster_options.h"

namespace cairn::fusion {

// Of positive numbers.
struct Spread {
  double mean = 0.0;
  double standard_deviation = 0.0;
};

struct Smoothness {
  double rms = 0.0;
  double percentile_95 = 0.0;
  double maximum = 0.0;
};

// How one estimator did.
struct MethodResult {
  // "EKF", "BA-10-5"; "-M" with marginalisation, "-F" with every frame a keyframe; ", steady" of
  // what a display would show.
  std::string name;
  bool is_steady = false;
  size_t num_counted_frames = 0;
  double position_rmse_m = 0.0;
  double rotation_rmse_rad = 0.0;
  Spread position_error_m;  // Over frames, as in the paper's table.
  Spread rotation_error_rad;
  // Change of the error from frame to frame, with the error in global: |e_k - e_k-1| and
  // |Log(E_k E_k-1')|.
  Smoothness position_change_m;
  Smoothness rotation_change_rad;
  // CPU time, one thread, of counted frames; propagation and preintegration are not in it.
  Spread update_seconds;      // The update by an answer; see CompareEstimators.
  Spread frame_seconds;       // Everything for a frame that comes with an answer.
  double mean_matches = 0.0;  // In an update.
};

// One row of the table besides the filter's.
struct RivalVariant {
  int num_cameras = 10;
  int num_iterations = 10;
  DiscardPolicy discard = DiscardPolicy::kDiscard;
  // The window holds the last frames one by one, as the filter's does, instead of the queried ones.
  bool every_frame_is_keyframe = false;

  std::string Name() const;
};

// The paper's: BA-10-10, BA-10-5, BA-5-10, BA-5-5, BA-5-2; then BA-10-5 and BA-5-2 with
// marginalisation.
std::vector<RivalVariant> PaperVariants();

// What all variants have in common with the filter on a recording: camera, rig, noise, gravity.
BundleAdjusterOptions RivalOptions(const Recording& recording, const RivalVariant& variant);

struct ComparisonOptions {
  std::vector<RivalVariant> variants = PaperVariants();
  // The recording is run this often; times are those of the fastest run, frame by frame. The
  // estimates are those of the first.
  int num_timings = 1;
  // Whether the rivals, too, are steadied; in rows of their own behind all others.
  bool steadies_rivals = false;

  // Throws Error(kInvalidArgument) naming what makes no sense.
  void Validate() const;
};

// The filter first, then the poses that it publishes for displays
// (Estimate::steady_global_from_imu; the times are the filter's), then each variant, on the same
// samples, tracks, answers and noise, each answer reaching them one frame after its query. Times of
// an update: of the rivals, gating the matches, building the problem and solving it. Of the filter,
// gating, compressing and applying all matches of the answer, on a copy of its state. (Its frames
// with an answer may cost less than those without, as sights that go into the answer are not used
// as tracks, so a difference says nothing.) Its whole frame, propagation and local tracks included,
// is `frame_seconds`. Throws Error(kBadInput) if a recording has fewer than two counted frames or
// its samples do not span its frames.
std::vector<MethodResult> CompareEstimators(const Recording& recording,
                                            const ComparisonOptions& options);

// The table as text, and the ratios of the filter and of its steady poses, the first two results,
// to the others.
std::string ComparisonTable(const std::string& title, std::span<const MethodResult> results);

}  // namespace cairn::fusion

#endif  // CAIRN_LAB_RIVALS_FUSION_COMPARISON_H_
