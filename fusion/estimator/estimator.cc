#include "fusion/estimator/estimator.h"

#include <algorithm>
#include <cmath>

#include "core/inertial/imu_time.h"
#include "fusion/estimator/estimate_at_head.h"
#include "fusion/tracks/finished_tracks.h"
#include "fusion/tracks/point_update.h"
#include "fusion/tracks/track_update.h"

namespace cairn::fusion {
namespace {

constexpr int kImuCapacity = 4096;  // 4 s at 1 kHz, 20 s at 200 Hz.
constexpr size_t kMaxWaitingFrames = 8;
constexpr int kMaxOutOfOrder = 20;  // In a row: the clock has been set back.
constexpr double kMaxWithoutFramesS = 1.0;
// Longest gap between inertial samples that the filter bridges. After a longer gap, `local` starts
// over.
constexpr double kMaxImuGapS = 0.3;
// Largest change per frame by which a correction of the map moves the position or yaw of `local`.
// The limits keep local_from_imu free of jumps.
constexpr double kMaxSlewMPerFrame = 0.01;
constexpr double kMaxSlewRadPerFrame = 0.002;
// Largest standard deviation of the velocity, per axis. Above it, tracks are of no use: `local` is
// lost, and the filter looks for a new start.
constexpr double kMaxVelocitySigmaMS = 2.0;
// Coasting begins this long after the last applied answer.
constexpr double kCoastingAfterS = 5.0;

const FusionOptions& Validated(const FusionOptions& options) {
  options.Validate();
  return options;
}

StarterOptions StarterOptionsOf(const FusionOptions& options) {
  return {.camera = options.camera,
          .rig = options.rig,
          .imu_noise = options.imu_noise,
          .gravity_m_s2 = options.gravity_m_s2,
          .standstill = options.standstill,
          .dynamic_start = options.dynamic_start,
          .tracks = options.tracks};
}

bool IsVelocityKnown(const FilterState& state) {
  const double variance = state.covariance().diagonal().segment<3>(kVelocityIdx).maxCoeff();
  return variance < std::pow(kMaxVelocitySigmaMS, 2);
}

}  // namespace

Estimator::Local::Local(const FusionOptions& options, int64_t start_ns, const StartState& start)
    : state(start.imu, start.covariance, options.rig, options.state),
      time_ns(start_ns),
      tracks(kMaxTrackedFeatures),
      standstill(options.standstill),
      rotation_only(options.camera, options.max_clones),
      head(options.imu_noise, options.gravity_m_s2),
      slew(kMaxSlewMPerFrame, kMaxSlewRadPerFrame),
      steady(options.steady) {}

Estimator::Estimator(const FusionOptions& options)
    : options_(Validated(options)),
      imu_(kImuCapacity),
      starter_(StarterOptionsOf(options)),
      answers_(options) {}

int64_t Estimator::ImuTime(int64_t frame_timestamp_ns) const {
  const Rig& rig = local_ ? local_->state.rig() : options_.rig;
  return frame_timestamp_ns + ToNanoseconds(rig.time_offset_s);
}

ImuStatus Estimator::AddImu(const ImuSample& sample) {
  if (!sample.gyro_rad_s.allFinite() || !sample.accel_m_s2.allFinite() || sample.timestamp_ns < 0) {
    return ImuStatus::kBadInput;
  }
  ImuStatus status = ImuStatus::kAccepted;
  if (!imu_.empty()) {
    const int64_t step_ns = sample.timestamp_ns - imu_.newest_ns();
    if (step_ns <= 0 && ++num_out_of_order_ < kMaxOutOfOrder) {
      return ImuStatus::kOutOfOrder;
    }
    if (step_ns <= 0 || ToSeconds(step_ns) > kMaxImuGapS) {
      Restart(local_ ? Mode::kLost : latest_.mode);
      status = ImuStatus::kRestarted;
    }
  }
  num_out_of_order_ = 0;
  imu_.Push(sample);
  if (local_) {
    local_->head.CarryOn(imu_);
  }
  ProcessWaitingFrames();
  CatchUpWithoutFrames();
  Publish();
  return status;
}

FrameStatus Estimator::AddFrame(const Frame& frame) {
  if (frame.timestamp_ns < 0) {
    return FrameStatus::kBadInput;
  }
  if (frame.timestamp_ns <= last_frame_ns_ ||
      (local_ && ImuTime(frame.timestamp_ns) <= local_->time_ns)) {
    return FrameStatus::kOutOfOrder;
  }
  if (waiting_.size() == kMaxWaitingFrames) {
    return FrameStatus::kQueueFull;
  }
  last_frame_ns_ = frame.timestamp_ns;
  waiting_.push_back({frame.timestamp_ns, {frame.features.begin(), frame.features.end()}});
  ProcessWaitingFrames();
  Publish();
  return FrameStatus::kAccepted;
}

std::optional<Query> Estimator::PollQuery() {
  return local_ ? answers_.Poll(local_->state, &local_->tracks) : std::nullopt;
}

void Estimator::Restart(Mode mode) {
  latest_.mode = mode;
  latest_.has_global = false;
  local_.reset();
  imu_.Clear();
  starter_.Clear();
  answers_.Restart();
  waiting_.clear();
  last_frame_ns_ = -1;
}

void Estimator::StartAt(int64_t timestamp_ns, const StartState& start) {
  local_ = std::make_unique<Local>(options_, timestamp_ns, start);
  local_->head.Restart(local_->state, timestamp_ns);
  local_->head.CarryOn(imu_);
  ++latest_.epoch;
  Publish();
}

void Estimator::ProcessWaitingFrames() {
  while (!waiting_.empty() && !imu_.empty()) {
    const int64_t imu_time_ns = ImuTime(waiting_.front().timestamp_ns);
    if (imu_time_ns > imu_.newest_ns()) {
      return;
    }
    const WaitingFrame frame = std::move(waiting_.front());
    waiting_.pop_front();
    if (imu_time_ns < imu_.oldest_ns() || (local_ && imu_time_ns <= local_->time_ns)) {
      continue;
    }
    if (local_) {
      ProcessFrame(frame);
    } else {
      TryStart(frame);
    }
  }
}

void Estimator::TryStart(const WaitingFrame& frame) {
  const int64_t now_ns = ImuTime(frame.timestamp_ns);
  if (const auto start = starter_.AddFrame(next_frame_id_++, now_ns, frame.features, imu_)) {
    StartAt(now_ns, *start);
  }
}

void Estimator::PropagateTo(int64_t timestamp_ns) {
  FilterState& state = local_->state;
  ImuState end = state.imu();
  FirstEstimate first = state.first();
  ImuTransition transition;
  imu_.ForEachStep(local_->time_ns, timestamp_ns, [&](const ImuStep& step) {
    Propagate(step, options_.imu_noise, options_.gravity_m_s2, &end, &first, &transition);
  });
  state.Propagate(end, first, transition);
  local_->time_ns = timestamp_ns;
  imu_.DropBefore(timestamp_ns - ToNanoseconds(options_.standstill.window_s));
}

void Estimator::CatchUpWithoutFrames() {
  if (local_ && ToSeconds(imu_.newest_ns() - local_->time_ns) > 2.0 * kMaxWithoutFramesS) {
    PropagateTo(imu_.newest_ns() - ToNanoseconds(kMaxWithoutFramesS));
  }
}

void Estimator::ProcessFrame(const WaitingFrame& frame) {
  const int64_t now_ns = ImuTime(frame.timestamp_ns);
  const int64_t frame_id = next_frame_id_++;
  FilterState& state = local_->state;
  TrackTable& tracks = local_->tracks;
  const std::optional<PosesBeforeFrame> before = FindPosesBeforeFrame(state, local_->head);

  PropagateTo(now_ns);
  state.AddClone(frame_id, now_ns, imu_.Interpolate(now_ns).gyro_rad_s - state.imu().gyro_bias);
  tracks.AddFrame(frame_id, options_.camera, frame.features);
  const Rigid3d predicted = state.imu().local_from_imu;

  const StandstillUpdate standstill = local_->standstill.Update(imu_, tracks, &state);
  if (standstill.redundant_frame_id && !answers_.NeedsFrame(*standstill.redundant_frame_id)) {
    RemoveClone(FindClone(state, *standstill.redundant_frame_id));
  }
  const bool has_only_turned = local_->rotation_only.Update(tracks, &state);
  const AlignmentCounts alignment = answers_.TakeUp(now_ns, &state, &tracks);
  UpdateFromPoints(options_.camera, frame_id, options_.tracks, &tracks, &state);
  std::vector<FinishedTrack> finished =
      TakeFinishedTracks(state.clones(), options_.max_clones, kMinTrackViews, &tracks);
  const TrackUpdateCounts used =
      UpdateFromTracks(options_.camera, std::move(finished), options_.tracks, &state);
  RetireClones();
  tracks.DropFinished(frame_id);

  ++counters_.num_frames;
  counters_.num_standstills += standstill.is_still;
  counters_.num_rotations += has_only_turned;
  counters_.num_alignments += alignment.num_alignments;
  counters_.num_realignments += alignment.num_realignments;
  counters_.num_tracks_used += used.num_used;
  counters_.num_tracks_gated += used.num_gated;
  if (!IsVelocityKnown(state)) {
    Restart(Mode::kLost);
    return;
  }
  CorrectHead(predicted, before, alignment.num_alignments > 0);
}

void Estimator::CorrectHead(const Rigid3d& predicted, const std::optional<PosesBeforeFrame>& before,
                            bool has_aligned) {
  const FilterState& state = local_->state;
  local_->slew.TakeUp(predicted, state.imu().local_from_imu);
  local_->slew.Return(state.imu().local_from_imu);
  local_->head.Restart(state, local_->time_ns);
  local_->head.CarryOn(imu_);
  if (before && state.global_from_local() && !has_aligned) {
    TakeUpCorrection(*before, state, local_->head, local_->time_ns, &local_->steady);
  } else {
    local_->steady.Reset();
  }
}

void Estimator::RemoveClone(int clone) {
  local_->tracks.DropFrame(local_->state.clones()[static_cast<size_t>(clone)].frame_id);
  local_->state.RemoveClone(clone);
}

void Estimator::RetireClones() {
  const auto& clones = local_->state.clones();
  for (int i = static_cast<int>(clones.size()) - options_.max_clones - 1; i >= 0; --i) {
    if (!answers_.NeedsFrame(clones[static_cast<size_t>(i)].frame_id)) {
      RemoveClone(i);
    }
  }
}

Mode Estimator::TrackingMode() const {
  if (!local_->state.global_from_local()) {
    return answers_.awaits_alignment() ? Mode::kAligning : Mode::kTracking;
  }
  const double since_s = ToSeconds(local_->head.time_ns() - *answers_.last_applied_ns());
  return since_s < kCoastingAfterS ? Mode::kLocalized : Mode::kCoasting;
}

void Estimator::Publish() {
  if (local_) {
    const int64_t epoch = latest_.epoch;
    latest_ = EstimateAtHead(local_->state, local_->head, local_->slew, local_->steady);
    latest_.epoch = epoch;
    latest_.mode = TrackingMode();
  }
}

}  // namespace cairn::fusion
