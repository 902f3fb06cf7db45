// Recordings for comparisons, from the fusion tests' simulation.
#ifndef CAIRN_TESTS_FUSION_RIVAL_SIMULATED_RECORDING_H_
#define CAIRN_TESTS_FUSION_RIVAL_SIMULATED_RECORDING_H_

#include <string>

#include "fusion/rival/recording.h"
#include "fusion/simulation.h"

namespace cairn::fusion::testing {

struct RecordingOptions {
  std::string name = "walk";
  int frames_per_query = 5;
  int max_matches = 300;
  double wrong_fraction = 0.0;
  double first_counted_s = 5.0;  // After the first frame.
};

inline Recording MakeRecording(const Simulation& simulation, const RecordingOptions& options) {
  Recording recording;
  recording.name = options.name;
  recording.options = simulation.MatchingOptions();
  recording.imu = simulation.imu();
  recording.frames_per_query = options.frames_per_query;
  recording.start = simulation.DrawStart(0, simulation.options().seed);
  recording.first_counted_frame =
      static_cast<size_t>(options.first_counted_s * simulation.options().frame_rate_hz);
  const AnswerOptions answers{.max_matches = options.max_matches,
                              .wrong_fraction = options.wrong_fraction,
                              .global_from_true_global = {}};
  for (size_t i = 0; i < simulation.frames().size(); ++i) {
    const SimulatedFrame& simulated = simulation.frames()[i];
    RecordedFrame frame;
    frame.timestamp_ns = simulated.truth.timestamp_ns;
    frame.features = simulated.features;
    frame.global_from_imu = simulated.truth.world_from_imu;
    if (i > 0 && i % static_cast<size_t>(options.frames_per_query) == 0) {
      Query query;
      query.query_id = static_cast<int64_t>(i);
      query.timestamp_ns = frame.timestamp_ns;
      query.features = frame.features;
      frame.answer = simulation.MakeAnswer(query, i, answers);
    }
    recording.frames.push_back(std::move(frame));
  }
  return recording;
}

}  // namespace cairn::fusion::testing

#endif  // CAIRN_TESTS_FUSION_RIVAL_SIMULATED_RECORDING_H_
