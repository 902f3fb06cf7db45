// Feeds a recording to the filter or to a bundle adjustment.
#ifndef CAIRN_LAB_RIVALS_FUSION_RUN_ESTIMATORS_H_
#define CAIRN_LAB_RIVALS_FUSION_RUN_ESTIMATORS_H_

#include <optional>
#include <vector>

#include "core/rigid3.h"
#include "lab/recordings/recording.h"
#include "lab/rivals/fusion/bundle_adjuster_options.h"

namespace cairn::fusion {

// What an estimator made of one frame.
struct FrameRun {
  std::optional<Rigid3d> global_from_imu;  // Nothing before it found the map.
  // What a display would show of it: see SteadyPose, with the recording's FusionOptions::steady.
  std::optional<Rigid3d> steady_global_from_imu;
  double seconds = 0.0;  // CPU time of this thread.
  // Of the update by the answer alone: of the filter, that by all matches of the answer at the
  // clone of its query, on a copy of the state; of a bundle adjuster, as `seconds`.
  double update_seconds = 0.0;
  bool had_answer = false;  // An answer was taken up.
  int num_matches = 0;      // Of it, that were used.
};

// One entry a frame; the first is that of the start. Keyframes of the bundle adjustment are the
// queried frames, or all of them. Throws Error(kBadInput) if the samples do not
// span the frames.
std::vector<FrameRun> RunFilter(const Recording& recording);
std::vector<FrameRun> RunBundleAdjuster(const Recording& recording,
                                        const BundleAdjusterOptions& options,
                                        bool every_frame_is_keyframe);

}  // namespace cairn::fusion

#endif  // CAIRN_LAB_RIVALS_FUSION_RUN_ESTIMATORS_H_
