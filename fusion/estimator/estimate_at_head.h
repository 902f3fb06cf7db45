// Makes the published estimate from the head.
#ifndef CAIRN_FUSION_ESTIMATOR_ESTIMATE_AT_HEAD_H_
#define CAIRN_FUSION_ESTIMATOR_ESTIMATE_AT_HEAD_H_

#include <cstdint>
#include <optional>

#include "core/rigid3.h"
#include "fusion/estimator/fusion_types.h"
#include "fusion/estimator/head.h"
#include "fusion/estimator/local_slew.h"
#include "fusion/estimator/steady_pose.h"
#include "fusion/filter/filter_state.h"

namespace cairn::fusion {

// Poses of the IMU in global before a frame corrects them.
struct PosesBeforeFrame {
  Rigid3d at_head;
  Rigid3d at_last_frame;
  int64_t last_frame_id = 0;
  int64_t last_frame_ns = 0;
};

// Returns nothing before the alignment or without a frame.
std::optional<PosesBeforeFrame> FindPosesBeforeFrame(const FilterState& state, const Head& head);

// Passes the correction by the frame at `frame_ns` to `steady`. The correction is that of the last
// frame's pose or, if the state no longer has a clone of that frame, that of the head's pose.
// `state` and `head` are those after the frame. `state` must be aligned.
void TakeUpCorrection(const PosesBeforeFrame& before, const FilterState& state, const Head& head,
                      int64_t frame_ns, SteadyPose* steady);

// Returns the estimate at the head. Mode and epoch are not set. Does not allocate.
Estimate EstimateAtHead(const FilterState& state, const Head& head, const LocalSlew& slew,
                        const SteadyPose& steady);

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_ESTIMATOR_ESTIMATE_AT_HEAD_H_
