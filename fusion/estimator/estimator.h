// The estimator: takes frames, inertial samples and answers, gives poses and queries.
#ifndef CAIRN_FUSION_ESTIMATOR_ESTIMATOR_H_
#define CAIRN_FUSION_ESTIMATOR_ESTIMATOR_H_

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/inertial/imu_buffer.h"
#include "fusion/estimator/estimate_at_head.h"
#include "fusion/estimator/fusion_options.h"
#include "fusion/estimator/fusion_types.h"
#include "fusion/estimator/head.h"
#include "fusion/estimator/local_slew.h"
#include "fusion/estimator/map_answers.h"
#include "fusion/estimator/steady_pose.h"
#include "fusion/filter/filter_state.h"
#include "fusion/start/standstill_updates.h"
#include "fusion/start/starter.h"
#include "fusion/tracks/rotation_only.h"
#include "fusion/tracks/track_table.h"

namespace cairn::fusion {

// Events since construction.
struct EstimatorCounters {
  int64_t num_frames = 0;
  int64_t num_tracks_used = 0;
  int64_t num_tracks_gated = 0;
  int64_t num_standstills = 0;  // Frames with a zero-velocity update.
  int64_t num_rotations = 0;    // Updates because the device has only turned.
  int64_t num_alignments = 0;
  int64_t num_realignments = 0;  // Alignments that contradictions ended.
};

// Deterministic: the same calls give the same estimates, bit for bit. The options bound the memory.
// Only the constructor throws, Error(kInvalidArgument). Not thread-safe, but for Submit.
//
// Starter finds the first state. From then on, ProcessFrame updates the state with each frame, Head
// propagates it with each sample, and MapAnswers queries the map and applies the answers.
class Estimator {
 public:
  explicit Estimator(const FusionOptions& options);

  // Adds a sample. Does not allocate unless the sample completes a waiting frame.
  ImuStatus AddImu(const ImuSample& sample);

  // Adds a frame. The frame is processed as soon as the inertial samples reach its time.
  FrameStatus AddFrame(const Frame& frame);

  // Starts at a known state. The inertial samples must have reached `timestamp_ns`.
  void StartAt(int64_t timestamp_ns, const StartState& start);

  // Returns a query of the newest frame if a query is due.
  std::optional<Query> PollQuery();

  // Queues an answer, from any thread. The next frame applies all queued answers, in the order of
  // their queries. While 32 answers wait, it refuses others.
  SubmitStatus Submit(Answer answer) { return answers_.Submit(std::move(answer)); }

  // Returns the outcomes of the answers since the last call, at most the last 64.
  std::vector<AnswerReport> TakeReports() { return answers_.TakeReports(); }

  // The estimate at the newest inertial sample.
  const Estimate& latest() const { return latest_; }
  const EstimatorCounters& counters() const { return counters_; }

  // The filter at its newest frame; nullptr while initializing or lost.
  const FilterState* state() const { return local_ ? &local_->state : nullptr; }
  // Time of that state; 0 without one.
  int64_t filter_time_ns() const { return local_ ? local_->time_ns : 0; }

 private:
  struct WaitingFrame {
    int64_t timestamp_ns;
    std::vector<TrackedFeature> features;
  };

  // Everything that lasts from a start until `local` is lost.
  struct Local {
    Local(const FusionOptions& options, int64_t start_ns, const StartState& start);

    FilterState state;
    int64_t time_ns;  // Time of `state`.
    TrackTable tracks;
    StandstillUpdates standstill;
    RotationOnlyUpdates rotation_only;
    Head head;
    LocalSlew slew;
    SteadyPose steady;
  };

  int64_t ImuTime(int64_t frame_timestamp_ns) const;
  void Restart(Mode mode);
  void ProcessWaitingFrames();
  void TryStart(const WaitingFrame& frame);
  void ProcessFrame(const WaitingFrame& frame);
  // Restarts the head at the updated state, and smooths the correction in the published poses.
  // `predicted` is local_from_imu at the frame before its updates.
  void CorrectHead(const Rigid3d& predicted, const std::optional<PosesBeforeFrame>& before,
                   bool has_aligned);
  void PropagateTo(int64_t timestamp_ns);
  void CatchUpWithoutFrames();
  void RemoveClone(int clone);
  // Removes the clones that are older than the window, except those that answers need.
  void RetireClones();
  Mode TrackingMode() const;
  void Publish();

  FusionOptions options_;
  ImuBuffer imu_;
  int num_out_of_order_ = 0;
  std::deque<WaitingFrame> waiting_;
  int64_t last_frame_ns_ = -1;
  int64_t next_frame_id_ = 1;
  Starter starter_;
  std::unique_ptr<Local> local_;  // Null while initializing or lost.
  MapAnswers answers_;
  Estimate latest_;
  EstimatorCounters counters_;
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_ESTIMATOR_ESTIMATOR_H_
