// Runs the filter or a bundle adjustment on a recording.
#ifndef CAIRN_LAB_RIVALS_FUSION_RUN_ESTIMATORS_H_
#define CAIRN_LAB_RIVALS_FUSION_RUN_ESTIMATORS_H_

#include <optional>
#include <vector>

#include "core/rigid3.h"
#include "eval/recordings/recording.h"
#include "lab/rivals/fusion/bundle_adjuster_options.h"

namespace cairn::fusion {

// An estimator's result for one frame.
struct FrameRun {
  std::optional<Rigid3d> global_from_imu;  // Null before the estimator found the map.
  // The pose that a display would show; see SteadyPose, with the recording's FusionOptions::steady.
  std::optional<Rigid3d> steady_global_from_imu;
  double seconds = 0.0;  // CPU time of this thread.
  // CPU time of the update by the answer alone. For the filter: the update by all matches of the
  // answer at the clone of its query, on a copy of the state. For a bundle adjuster: same as
  // `seconds`.
  double update_seconds = 0.0;
  bool had_answer = false;  // The estimator processed an answer.
  int num_matches = 0;      // Matches of the answer that were used.
};

// Return one entry per frame; the first entry is the start. The keyframes of the bundle adjustment
// are the queried frames or all frames. Throw Error(kBadInput) if the samples do not span the
// frames.
std::vector<FrameRun> RunFilter(const Recording& recording);
std::vector<FrameRun> RunBundleAdjuster(const Recording& recording,
                                        const BundleAdjusterOptions& options,
                                        bool every_frame_is_keyframe);

}  // namespace cairn::fusion

#endif  // CAIRN_LAB_RIVALS_FUSION_RUN_ESTIMATORS_H_
