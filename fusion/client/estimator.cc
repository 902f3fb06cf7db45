#include "fusion/client/estimator.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "fusion/filter/chi_square.h"
#include "fusion/tracks/point_update.h"

namespace cairn::fusion {
namespace {

constexpr int kImuCapacity = 4096;  // 4 s at 1 kHz, 20 s at 200 Hz.
constexpr size_t kMaxWaitingFrames = 8;
constexpr int kMaxOutOfOrder = 20;  // In a row: the clock has been set back.
constexpr double kMaxWithoutFramesS = 1.0;

double Seconds(int64_t duration_ns) { return 1e-9 * static_cast<double>(duration_ns); }
int64_t Nanoseconds(double duration_s) { return static_cast<int64_t>(duration_s * 1e9); }

const FusionOptions& Validated(const FusionOptions& options) {
  options.Validate();
  return options;
}

}  // namespace

Estimator::Estimator(const FusionOptions& options)
    : options_(Validated(options)),
      imu_(kImuCapacity),
      tracks_(options.max_tracks),
      slew_(options.max_slew_m_per_frame, options.max_slew_rad_per_frame),
      steady_(options.steady) {}

int64_t Estimator::ImuTime(int64_t frame_timestamp_ns) const {
  const Rig& rig = state_ ? state_->rig() : options_.rig;
  return frame_timestamp_ns + Nanoseconds(rig.time_offset_s);
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
    if (step_ns <= 0 || Seconds(step_ns) > options_.max_imu_gap_s) {
      Restart(state_ ? Mode::kLost : resting_mode_);
      status = ImuStatus::kRestarted;
    }
  }
  num_out_of_order_ = 0;
  imu_.Push(sample);
  if (state_) {
    imu_.ForEachStep(head_time_ns_, sample.timestamp_ns,
                     [this](const ImuStep& step) { AdvanceHead(step); });
    head_time_ns_ = std::max(head_time_ns_, sample.timestamp_ns);
  }
  ProcessWaitingFrames();
  CatchUpWithoutFrames();
  PublishHead();
  return status;
}

FrameStatus Estimator::AddFrame(const Frame& frame) {
  if (frame.timestamp_ns < 0) {
    return FrameStatus::kBadInput;
  }
  if (frame.timestamp_ns <= last_frame_ns_ ||
      (state_ && ImuTime(frame.timestamp_ns) <= filter_time_ns_)) {
    return FrameStatus::kOutOfOrder;
  }
  if (waiting_.size() == kMaxWaitingFrames) {
    return FrameStatus::kQueueFull;
  }
  last_frame_ns_ = frame.timestamp_ns;
  waiting_.push_back({frame.timestamp_ns, {frame.features.begin(), frame.features.end()}});
  ProcessWaitingFrames();
  PublishHead();
  return FrameStatus::kAccepted;
}

void Estimator::Restart(Mode mode) {
  resting_mode_ = mode;
  state_.reset();
  imu_.Clear();
  tracks_.Clear();
  slew_.Reset();
  steady_.Reset();
  landmark_uses_.Clear();
  waiting_.clear();
  start_frames_.clear();
  standstill_anchor_.reset();
  pending_.clear();
  candidates_.clear();
  contradictions_.clear();
  last_query_ns_.reset();
  last_applied_ns_.reset();
  last_rotation_only_ns_ = 0;
  last_frame_ns_ = -1;
}

void Estimator::StartAt(int64_t timestamp_ns, const StartState& start) {
  state_ = std::make_unique<FilterState>(start.imu, start.covariance, options_.rig, options_.state);
  filter_time_ns_ = timestamp_ns;
  ++epoch_;
  RestartHead();
  PublishHead();
}

void Estimator::ProcessWaitingFrames() {
  while (!waiting_.empty() && !imu_.empty()) {
    const int64_t imu_time_ns = ImuTime(waiting_.front().timestamp_ns);
    if (imu_time_ns > imu_.newest_ns()) {
      return;
    }
    const WaitingFrame frame = std::move(waiting_.front());
    waiting_.pop_front();
    if (imu_time_ns < imu_.oldest_ns() || (state_ && imu_time_ns <= filter_time_ns_)) {
      continue;
    }
    if (state_) {
      ProcessFrame(frame);
    } else {
      TryStart(frame);
    }
  }
}

void Estimator::TryStart(const WaitingFrame& frame) {
  const int64_t now_ns = ImuTime(frame.timestamp_ns);
  const int64_t static_begin_ns = now_ns - Nanoseconds(options_.standstill.start_window_s);
  const int64_t begin_ns =
      std::min(static_begin_ns, now_ns - Nanoseconds(options_.dynamic_start.window_s));
  const int64_t frame_id = next_frame_id_++;
  tracks_.AddFrame(frame_id, options_.camera, frame.features);
  start_frames_.push_back({frame_id, now_ns});
  while (start_frames_.front().timestamp_ns < begin_ns) {
    tracks_.DropFrame(start_frames_.front().frame_id);
    start_frames_.pop_front();
  }
  const auto first_static = std::find_if(
      start_frames_.begin(), start_frames_.end(),
      [&](const StartFrame& start_frame) { return start_frame.timestamp_ns >= static_begin_ns; });
  const auto disparity =
      MedianDisparity(tracks_, first_static->frame_id, frame_id, options_.standstill);
  const bool moves = disparity && *disparity > options_.standstill.max_disparity_px;
  std::optional<StartState> start;
  if (moves) {
    start = TryDynamicStart();
  } else if (imu_.Covers(static_begin_ns, now_ns)) {
    start = StaticStart(imu_, static_begin_ns, now_ns, options_.imu_noise, options_.gravity_m_s2,
                        options_.start, options_.standstill);
  }
  tracks_.DropFinished(frame_id);
  if (start) {
    tracks_.Clear();
    start_frames_.clear();
    StartAt(now_ns, *start);
  }
}

std::optional<StartState> Estimator::TryDynamicStart() const {
  const DynamicStartOptions& options = options_.dynamic_start;
  const int64_t now_ns = start_frames_.back().timestamp_ns;
  const double spanned_s = Seconds(now_ns - start_frames_.front().timestamp_ns);
  // Nearly the whole window; and, as it takes the time of many frames, not with each.
  if (!options.enabled || spanned_s < 0.8 * options.window_s ||
      start_frames_.back().frame_id % 3 != 0 ||
      !imu_.Covers(start_frames_.front().timestamp_ns, now_ns)) {
    return std::nullopt;
  }
  const size_t stride = (start_frames_.size() - 1) / static_cast<size_t>(options.max_frames) + 1;
  std::vector<StartFrame> frames;
  for (size_t i = (start_frames_.size() - 1) % stride; i < start_frames_.size(); i += stride) {
    frames.push_back(start_frames_[i]);
  }
  return DynamicStart({imu_, tracks_, frames, options_.camera, options_.rig, options_.imu_noise,
                       options_.gravity_m_s2, options_.tracks},
                      options);
}

void Estimator::PropagateTo(int64_t timestamp_ns) {
  ImuState end = state_->imu();
  FirstEstimate first = state_->first();
  ImuTransition transition;
  imu_.ForEachStep(filter_time_ns_, timestamp_ns, [&](const ImuStep& step) {
    Propagate(step, options_.imu_noise, options_.gravity_m_s2, &end, &first, &transition);
  });
  state_->Propagate(end, first, transition);
  filter_time_ns_ = timestamp_ns;
  imu_.DropBefore(timestamp_ns - Nanoseconds(options_.standstill.window_s));
}

void Estimator::CatchUpWithoutFrames() {
  if (state_ && Seconds(imu_.newest_ns() - filter_time_ns_) > 2.0 * kMaxWithoutFramesS) {
    PropagateTo(imu_.newest_ns() - Nanoseconds(kMaxWithoutFramesS));
  }
}

void Estimator::ProcessFrame(const WaitingFrame& frame) {
  const int64_t now_ns = ImuTime(frame.timestamp_ns);
  const int64_t frame_id = next_frame_id_++;
  const std::optional<Uncorrected> uncorrected = BeforeFrame();
  PropagateTo(now_ns);
  state_->AddClone(frame_id, now_ns, imu_.Interpolate(now_ns).gyro_rad_s - state_->imu().gyro_bias);
  tracks_.AddFrame(frame_id, options_.camera, frame.features);
  ++counters_.num_frames;
  const Rigid3d predicted = state_->imu().local_from_imu;
  CheckStandstill();
  CheckRotationOnly();
  ExpireQueries();
  ProcessAnswers();
  UpdateFromPoints(options_.camera, frame_id, options_.tracks, &tracks_, state_.get());
  UpdateFromFinishedTracks();
  RetireClones();
  tracks_.DropFinished(frame_id);
  slew_.TakeUp(predicted, state_->imu().local_from_imu);
  slew_.Return(state_->imu().local_from_imu);
  const double velocity_variance =
      state_->covariance().diagonal().segment<3>(kVelocityIdx).maxCoeff();
  if (!(velocity_variance < std::pow(options_.max_velocity_sigma_m_s, 2))) {
    Restart(Mode::kLost);
    return;
  }
  RestartHead();
  SteadyHead(uncorrected);
}

void Estimator::CheckStandstill() {
  const StandstillOptions& options = options_.standstill;
  const int newest = static_cast<int>(state_->clones().size()) - 1;
  const int64_t begin_ns = filter_time_ns_ - Nanoseconds(options.window_s);
  if (newest < 1 || !imu_.Covers(begin_ns, filter_time_ns_) ||
      !IsQuiet(imu_, begin_ns, filter_time_ns_, options)) {
    standstill_anchor_.reset();
    return;
  }
  const auto& clones = state_->clones();
  const int64_t previous_frame = clones[static_cast<size_t>(newest) - 1].frame_id;
  const int64_t anchor_frame = standstill_anchor_.value_or(previous_frame);
  const auto disparity =
      MedianDisparity(tracks_, anchor_frame, clones[static_cast<size_t>(newest)].frame_id, options);
  const Measurement measurement =
      StandstillMeasurement(*state_, FindClone(*state_, anchor_frame), options);
  if (!disparity || *disparity > options.max_disparity_px ||
      state_->SquaredMahalanobis(measurement) >
          ChiSquareQuantile(measurement.num_rows(), options.gate_quantile)) {
    standstill_anchor_.reset();
    return;
  }
  state_->Update(measurement);
  ++counters_.num_standstills;
  standstill_anchor_ = anchor_frame;
  // While at rest the window keeps its past views rather than many of one place.
  if (previous_frame != anchor_frame && !Keeps(previous_frame)) {
    RemoveClone(newest - 1);
  }
}

void Estimator::CheckRotationOnly() {
  const auto& clones = state_->clones();
  // From one such update to the next, so that none repeats what another has said.
  const auto begin = std::find_if(clones.begin(), clones.end(), [this](const Clone& clone) {
    return clone.timestamp_ns >= last_rotation_only_ns_;
  });
  const int from = static_cast<int>(begin - clones.begin());
  const int to = static_cast<int>(clones.size()) - 1;
  if (2 * (to - from) < options_.max_clones) {
    return;
  }
  const auto parallax_px =
      MedianParallaxPx(*state_, options_.camera, tracks_, from, to, options_.rotation_only);
  const auto measurement = parallax_px
                               ? RotationOnlyMeasurement(*state_, options_.camera, *parallax_px,
                                                         from, to, options_.rotation_only)
                               : std::nullopt;
  if (measurement && state_->SquaredMahalanobis(*measurement) <
                         ChiSquareQuantile(3, options_.rotation_only.gate_quantile)) {
    state_->Update(*measurement);
    last_rotation_only_ns_ = clones.back().timestamp_ns;
    ++counters_.num_rotations;
  }
}

void Estimator::UpdateFromFinishedTracks() {
  const auto& clones = state_->clones();
  const int64_t frame_id = clones.back().frame_id;
  const int leaving = static_cast<int>(clones.size()) - options_.max_clones - 1;
  const int64_t leaving_frame = leaving >= 0 ? clones[static_cast<size_t>(leaving)].frame_id : -1;
  std::vector<FinishedTrack> finished;
  for (Track& track : tracks_.tracks()) {
    const bool leaves =
        std::any_of(track.observations.begin(), track.observations.end(),
                    [leaving_frame](const Observation& observation) {
                      return observation.frame_id == leaving_frame && !observation.reserved;
                    });
    if (track.last_frame_id == frame_id && !leaves) {
      continue;
    }
    // The newest sight stays: it begins the track's next part, and it may be queried.
    const auto taken = [frame_id](const Observation& observation) {
      return !observation.reserved && observation.frame_id != frame_id;
    };
    std::vector<Observation> sights;
    std::copy_if(track.observations.begin(), track.observations.end(), std::back_inserter(sights),
                 taken);
    if (static_cast<int>(sights.size()) >= options_.tracks.min_views) {
      std::erase_if(track.observations, taken);
      finished.push_back({track.track_id, track.last_frame_id == frame_id, std::move(sights),
                          std::exchange(track.map_distance, std::nullopt)});
    }
  }
  const TrackUpdateCounts counts =
      UpdateFromTracks(options_.camera, std::move(finished), options_.tracks, state_.get());
  counters_.num_tracks_used += counts.num_used;
  counters_.num_tracks_gated += counts.num_gated;
}

bool Estimator::Keeps(int64_t frame_id) const {
  const auto is_frame = [frame_id](const auto& entry) { return entry.frame_id == frame_id; };
  return std::any_of(pending_.begin(), pending_.end(), is_frame) ||
         std::any_of(candidates_.begin(), candidates_.end(), is_frame);
}

void Estimator::RemoveClone(int clone) {
  const int64_t frame_id = state_->clones()[static_cast<size_t>(clone)].frame_id;
  tracks_.DropFrame(frame_id);
  state_->RemoveClone(clone);
  if (standstill_anchor_ == frame_id) {
    standstill_anchor_.reset();
  }
}

void Estimator::RetireClones() {
  for (int i = static_cast<int>(state_->clones().size()) - options_.max_clones - 1; i >= 0; --i) {
    if (!Keeps(state_->clones()[static_cast<size_t>(i)].frame_id)) {
      RemoveClone(i);
    }
  }
}

}  // namespace cairn::fusion
