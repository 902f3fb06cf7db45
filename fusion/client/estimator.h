// The whole estimator, single-threaded: frames and inertial samples in, poses and queries out.
#ifndef CAIRN_FUSION_CLIENT_ESTIMATOR_H_
#define CAIRN_FUSION_CLIENT_ESTIMATOR_H_

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "fusion/client/fusion_options.h"
#include "fusion/client/fusion_types.h"
#include "fusion/client/local_slew.h"
#include "fusion/client/steady_pose.h"
#include "fusion/filter/filter_state.h"
#include "fusion/filter/imu_buffer.h"
#include "fusion/map_updates/landmark_uses.h"
#include "fusion/start/standstill.h"
#include "fusion/tracks/track_table.h"

namespace cairn::fusion {

// What has happened since the construction.
struct EstimatorCounters {
  int64_t num_frames = 0;
  int64_t num_tracks_used = 0;
  int64_t num_tracks_gated = 0;
  int64_t num_standstills = 0;  // Frames with a zero-velocity update.
  int64_t num_rotations = 0;    // Updates that say the device has only turned.
  int64_t num_alignments = 0;
  int64_t num_realignments = 0;  // Alignments given up for contradictions.
};

// Deterministic: the same calls give bit for bit the same estimates. Memory is bounded by the
// options. Throws nothing but Error(kInvalidArgument) from the constructor. Not thread-safe.
class Estimator {
 public:
  explicit Estimator(const FusionOptions& options);

  // Allocates nothing unless it completes a waiting frame.
  ImuStatus AddImu(const ImuSample& sample);

  // Processed as soon as the inertial samples reach it.
  FrameStatus AddFrame(const Frame& frame);

  // Skips the start: the state at an instant the inertial samples have reached.
  void StartAt(int64_t timestamp_ns, const StartState& start);

  // The newest frame, as a query, if it is time for one.
  std::optional<Query> PollQuery();

  // Taken up at the next frame, together with all that have arrived by then, in the order of their
  // queries.
  SubmitStatus Submit(Answer answer);
  bool has_room_for_answer() const { return inbox_.size() < kMaxInbox; }

  // What became of the answers since the last call; the last 64 at most.
  std::vector<AnswerReport> TakeReports();

  // At the newest inertial sample.
  const Estimate& latest() const { return latest_; }
  const EstimatorCounters& counters() const { return counters_; }

  // The filter at its newest frame; nullptr while initializing or lost.
  const FilterState* state() const { return state_.get(); }
  int64_t filter_time_ns() const { return filter_time_ns_; }

 private:
  static constexpr size_t kMaxInbox = 32;

  struct WaitingFrame {
    int64_t timestamp_ns;
    std::vector<TrackedFeature> features;
  };
  struct PendingQuery {
    int64_t query_id;
    int64_t frame_id;
    int64_t timestamp_ns;
  };
  // An answer that waits for others to agree with it.
  struct Candidate {
    int64_t frame_id;
    Rigid3d global_from_local;
    std::vector<MapMatch> matches;
  };
  // Sights of landmarks, and the tracks in whose books they stand.
  struct LedgerSights {
    std::vector<MapSight> sights;
    std::vector<std::optional<uint64_t>> track_ids;
    std::vector<uint64_t> landmark_ids;

    void Add(const MapSight& sight, const MapMatch& match);
  };
  // Before a frame is taken up, in global.
  struct Uncorrected {
    Rigid3d at_head;
    Rigid3d at_last_frame;
    int64_t last_frame_id = 0;
    int64_t last_frame_ns = 0;
    int64_t num_alignments = 0;
  };
  struct Contradiction {
    int64_t timestamp_ns;
    Rigid3d global_from_local;
  };

  int64_t ImuTime(int64_t frame_timestamp_ns) const;
  void Restart(Mode mode);
  void ProcessWaitingFrames();
  void ProcessFrame(const WaitingFrame& frame);
  void TryStart(const WaitingFrame& frame);
  std::optional<StartState> TryDynamicStart() const;
  void PropagateTo(int64_t timestamp_ns);
  void CatchUpWithoutFrames();

  // Zero-velocity update if the device rests.
  void CheckStandstill();
  // Bounds the way if the camera has only turned.
  void CheckRotationOnly();
  void UpdateFromFinishedTracks();
  void RetireClones();
  void RemoveClone(int clone);
  bool Keeps(int64_t frame_id) const;

  void ExpireQueries();
  void ProcessAnswers();
  AnswerReport ProcessAnswer(const Answer& answer, int64_t frame_id);
  void AppendSights(const std::vector<MapMatch>& matches, int64_t frame_id, LedgerSights* sights);
  void AppendTrack(const Track& track, const MapMatch& match, int64_t frame_id, MapSight sight,
                   LedgerSights* sights) const;
  // What the error of a sight's landmark amounts to in the image; infinite before the alignment.
  double LandmarkNoisePx(const MapSight& sight) const;
  void TakeOut(const LedgerSights& sights, const std::vector<bool>& used);
  // Leaves with a track what its queried sight, just used, has not told of the landmark.
  void NoteDistance(const MapSight& sight, Track* track) const;
  // Gives landmarks back what the state has forgotten since the last answer.
  void ForgetUses();
  MapUpdateResult UpdateFromMatches(const std::vector<MapMatch>& matches, int64_t frame_id);
  AnswerReport Apply(const Answer& answer, int64_t frame_id, const Rigid3d& candidate);
  AnswerOutcome AwaitAlignment(const Answer& answer, int64_t frame_id, const Rigid3d& candidate);
  void NoteContradiction(int64_t frame_id, const Rigid3d& candidate);
  void TryAlign();
  void ReleaseCandidates(size_t num_oldest);
  void Report(const AnswerReport& report);

  void RestartHead();
  void AdvanceHead(const ImuStep& step);
  // At the newest inertial sample; nothing before the alignment.
  std::optional<Rigid3d> GlobalFromHead() const;
  // Nothing before the alignment.
  std::optional<Uncorrected> BeforeFrame() const;
  // After a frame.
  void SteadyHead(const std::optional<Uncorrected>& before);
  void PublishHead();

  FusionOptions options_;
  ImuBuffer imu_;
  TrackTable tracks_;
  std::unique_ptr<FilterState> state_;
  LocalSlew slew_;
  SteadyPose steady_;
  LandmarkUses landmark_uses_;
  Eigen::Matrix4d known_of_place_ = Eigen::Matrix4d::Zero();  // Covariance after the last answer.
  Mode resting_mode_ = Mode::kInitializing;                   // While there is no state.
  int64_t filter_time_ns_ = 0;
  int64_t last_frame_ns_ = -1;
  int64_t next_frame_id_ = 1;
  int num_out_of_order_ = 0;
  std::deque<WaitingFrame> waiting_;
  std::deque<StartFrame> start_frames_;  // Before the start.
  int64_t last_rotation_only_ns_ = 0;
  std::optional<int64_t> standstill_anchor_;  // Frame in which the device came to rest.

  std::vector<PendingQuery> pending_;
  std::vector<int64_t> given_up_;  // The last queries whose clone is gone.
  int64_t next_query_id_ = 1;
  std::optional<int64_t> last_query_ns_;
  std::vector<Answer> inbox_;
  std::vector<Candidate> candidates_;
  std::vector<Contradiction> contradictions_;
  std::deque<AnswerReport> reports_;
  std::optional<int64_t> last_applied_ns_;

  // The state carried on from the newest frame to the newest inertial sample.
  ImuState head_;
  FirstEstimate head_first_;
  Matrix15d head_covariance_ = Matrix15d::Zero();
  Eigen::Matrix<double, kImuDim, kGlobalDim> head_by_global_;  // Covariance with global_from_local.
  int64_t head_time_ns_ = 0;
  int64_t epoch_ = 0;
  Estimate latest_;
  EstimatorCounters counters_;
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_CLIENT_ESTIMATOR_H_
