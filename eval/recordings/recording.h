// A recording: one trip as sensors, tracker and map saw it, with the truth. Estimators are compared
// on recordings.
#ifndef CAIRN_EVAL_RECORDINGS_RECORDING_H_
#define CAIRN_EVAL_RECORDINGS_RECORDING_H_

#include <cstdint>
#include <string>
#include <vector>

#include "core/inertial/imu.h"
#include "core/rigid3.h"
#include "fusion/estimator/fusion_options.h"
#include "fusion/estimator/fusion_types.h"
#include "fusion/start/standstill.h"

namespace cairn::fusion {

struct RecordedFrame {
  int64_t timestamp_ns = 0;
  std::vector<TrackedFeature> features;
  Rigid3d global_from_imu;  // True pose.
  // The map's answer to a query of this frame. The answer reaches the estimator with the next
  // frame. Not localized if the frame was not queried. `query_id` has no meaning.
  Answer answer;
};

struct Recording {
  std::string name;
  // Camera, rig, gravity, and the noise of the IMU, of tracks and of matches apply to all
  // estimators. The remaining options apply to the filter.
  FusionOptions options;
  std::vector<ImuSample> imu;  // From before the first frame to after the last.
  std::vector<RecordedFrame> frames;
  // Every n-th frame is queried. The queried frames are the keyframes of the rivals.
  int frames_per_query = 5;
  // The state at the first frame that all estimators start from.
  StartState start;
  // Errors count from this frame on. Every estimator must have found the map by then.
  size_t first_counted_frame = 0;
};

}  // namespace cairn::fusion

#endif  // CAIRN_EVAL_RECORDINGS_RECORDING_H_
