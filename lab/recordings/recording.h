// What estimators are compared on: one trip, as sensors, tracker and map saw it, with the truth.
#ifndef CAIRN_LAB_RECORDINGS_RECORDING_H_
#define CAIRN_LAB_RECORDINGS_RECORDING_H_

#include <cstdint>
#include <string>
#include <vector>

#include "core/rigid3.h"
#include "fusion/client/fusion_options.h"
#include "fusion/client/fusion_types.h"
#include "fusion/filter/imu.h"
#include "fusion/start/standstill.h"

namespace cairn::fusion {

struct RecordedFrame {
  int64_t timestamp_ns = 0;
  std::vector<TrackedFeature> features;
  Rigid3d global_from_imu;  // Truth.
  // The map's answer to a query of this frame, which reaches the estimator with the next frame; not
  // localized if the frame was not asked about. `query_id` has no meaning.
  Answer answer;
};

struct Recording {
  std::string name;
  // Camera, rig, noise of the inertial unit, of tracks and of matches, and gravity hold for all
  // estimators; the rest is the filter's.
  FusionOptions options;
  std::vector<ImuSample> imu;  // From before the first frame to after the last.
  std::vector<RecordedFrame> frames;
  int frames_per_query = 5;  // Every n-th frame is asked about, and is a keyframe of the rivals.
  // The state at the first frame, as all estimators believe it.
  StartState start;
  // Errors count from this frame on, by which every estimator must have found the map.
  size_t first_counted_frame = 0;
};

}  // namespace cairn::fusion

#endif  // CAIRN_LAB_RECORDINGS_RECORDING_H_
