#include "lab/rivals/fusion/run_estimators.h"

#include <ctime>

#include "core/error.h"
#include "core/inertial/imu_buffer.h"
#include "fusion/estimator/estimator.h"
#include "fusion/estimator/steady_pose.h"
#include "fusion/map_updates/alignment.h"
#include "fusion/map_updates/map_update.h"
#include "lab/rivals/fusion/bundle_adjuster.h"

namespace cairn::fusion {
namespace {

double ThreadSeconds() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void CheckCovered(const Recording& recording) {
  if (recording.frames.empty() || recording.imu.empty() ||
      recording.imu.front().timestamp_ns > recording.frames.front().timestamp_ns ||
      recording.imu.back().timestamp_ns < recording.frames.back().timestamp_ns) {
    throw Error(ErrorCode::kBadInput,
                "recording " + recording.name + ": inertial samples do not span the frames");
  }
}

bool IsQueried(const Recording& recording, size_t frame) {
  return frame % static_cast<size_t>(recording.frames_per_query) == 0;
}

// Returns true if a report since the last call is about an answer with a pose. `num_matches`
// receives the number of applied matches.
bool TakeAnswer(Estimator* estimator, int* num_matches) {
  bool had_answer = false;
  for (const AnswerReport& report : estimator->TakeReports()) {
    *num_matches += report.num_matches;
    had_answer = had_answer || report.outcome != AnswerOutcome::kNotLocalized;
  }
  return had_answer;
}

std::optional<Rigid3d> GlobalFromImu(const Estimator& estimator) {
  const FilterState* state = estimator.state();
  if (state == nullptr || !state->global_from_local()) {
    return std::nullopt;
  }
  return *state->global_from_local() * state->imu().local_from_imu;
}

// The pose that the filter publishes for displays at its newest sample, moved back to the time of
// the frame.
std::optional<Rigid3d> SteadyGlobalFromImu(const Estimator& estimator,
                                           const SteadyPoseOptions& options) {
  const std::optional<Rigid3d> global_from_imu = GlobalFromImu(estimator);
  if (!global_from_imu) {
    return std::nullopt;
  }
  const Estimate& latest = estimator.latest();
  SteadyPose steady(options);
  steady.TakeUp(latest.timestamp_ns, latest.steady_global_from_imu, latest.global_from_imu);
  return steady.Show(estimator.filter_time_ns(), *global_from_imu);
}

std::optional<Rigid3d> GlobalFromImu(const BundleAdjuster& adjuster) {
  const auto global_from_local = adjuster.global_from_local();
  return global_from_local ? std::optional(*global_from_local * adjuster.state().local_from_imu)
                           : std::nullopt;
}

// CPU time of the filter's update by an answer to a query about the frame before the newest: gates,
// compression and update.
double UpdateSeconds(const Recording& recording, const Estimator& estimator, const Answer& answer) {
  FilterState state = *estimator.state();
  if (!state.global_from_local() || state.clones().size() < 2) {
    return 0.0;
  }
  std::vector<MapObservation> observations;
  for (const MapMatch& match : answer.matches) {
    observations.push_back({.match = static_cast<int>(observations.size()),
                            .clone = static_cast<int>(state.clones().size()) - 2,
                            .pixel = match.pixel,
                            .x_in_global = match.x_in_global,
                            .sigma_m = match.sigma_m,
                            .tile_id = match.tile_id});
  }
  const double begin = ThreadSeconds();
  UpdateFromMap(recording.options.camera, observations, recording.options.map, &state);
  return ThreadSeconds() - begin;
}

std::vector<ImuStep> StepsBetween(const ImuBuffer& buffer, int64_t begin_ns, int64_t end_ns) {
  std::vector<ImuStep> steps;
  buffer.ForEachStep(begin_ns, end_ns, [&](const ImuStep& step) { steps.push_back(step); });
  return steps;
}

}  // namespace

std::vector<FrameRun> RunFilter(const Recording& recording) {
  CheckCovered(recording);
  FusionOptions options = recording.options;
  const int64_t frame_ns = recording.frames.size() > 1
                               ? recording.frames[1].timestamp_ns - recording.frames[0].timestamp_ns
                               : 1;
  // Queries every n-th frame, whatever the jitter of the timestamps.
  options.query.min_interval_s = 1e-9 * static_cast<double>(frame_ns) *
                                 (static_cast<double>(recording.frames_per_query) - 0.5);
  Estimator estimator(options);
  std::vector<FrameRun> runs(recording.frames.size());
  size_t next_imu = 0;
  for (size_t i = 0; i < recording.frames.size(); ++i) {
    const RecordedFrame& frame = recording.frames[i];
    while (next_imu < recording.imu.size() &&
           (next_imu == 0 || recording.imu[next_imu - 1].timestamp_ns < frame.timestamp_ns)) {
      estimator.AddImu(recording.imu[next_imu++]);
    }
    if (i == 0) {
      estimator.StartAt(frame.timestamp_ns, recording.start);
      continue;
    }
    const double begin = ThreadSeconds();
    estimator.AddFrame({frame.timestamp_ns, frame.features});
    runs[i].seconds = ThreadSeconds() - begin;
    runs[i].had_answer = TakeAnswer(&estimator, &runs[i].num_matches);
    if (runs[i].had_answer && estimator.state() != nullptr) {
      runs[i].update_seconds = UpdateSeconds(recording, estimator, recording.frames[i - 1].answer);
    }
    runs[i].global_from_imu = GlobalFromImu(estimator);
    runs[i].steady_global_from_imu = SteadyGlobalFromImu(estimator, options.steady);
    if (!IsQueried(recording, i)) {
      continue;
    }
    if (const auto query = estimator.PollQuery()) {
      Answer answer = frame.answer;
      answer.query_id = query->query_id;
      estimator.Submit(std::move(answer));
    }
  }
  return runs;
}

std::vector<FrameRun> RunBundleAdjuster(const Recording& recording,
                                        const BundleAdjusterOptions& options,
                                        bool every_frame_is_keyframe) {
  CheckCovered(recording);
  ImuBuffer buffer(static_cast<int>(recording.imu.size()));
  for (const ImuSample& sample : recording.imu) {
    buffer.Push(sample);
  }
  const RecordedFrame& first = recording.frames.front();
  BundleAdjuster adjuster(options, recording.start.imu, recording.start.covariance,
                          {0, first.timestamp_ns, true, {}, first.features});
  SteadyPose steady(recording.options.steady);
  std::vector<FrameRun> runs(recording.frames.size());
  for (size_t i = 1; i < recording.frames.size(); ++i) {
    const RecordedFrame& frame = recording.frames[i];
    const std::vector<ImuStep> steps =
        StepsBetween(buffer, recording.frames[i - 1].timestamp_ns, frame.timestamp_ns);
    // The filter's first query, too, is that of frame 1 * frames_per_query.
    adjuster.AddFrame({static_cast<int64_t>(i), frame.timestamp_ns,
                       every_frame_is_keyframe || IsQueried(recording, i), steps, frame.features});
    const std::optional<Rigid3d> predicted = GlobalFromImu(adjuster);
    const RecordedFrame& previous = recording.frames[i - 1];
    const bool has_answer = i > 1 && IsQueried(recording, i - 1) && previous.answer.localized;
    const double begin = ThreadSeconds();
    if (has_answer) {
      if (!adjuster.global_from_local()) {
        const Rigid3d local_from_imu = *adjuster.PoseOf(static_cast<int64_t>(i) - 1);
        const Rigid3d global_from_imu = previous.answer.global_from_cam * options.rig.cam_from_imu;
        adjuster.SetGlobalFromLocal(
            Level(global_from_imu * local_from_imu.Inverse(), local_from_imu.translation).level);
      }
      runs[i].had_answer = true;
      runs[i].num_matches =
          adjuster.AddMatches(static_cast<int64_t>(i) - 1, previous.answer.matches);
    }
    adjuster.Optimize();
    runs[i].seconds = ThreadSeconds() - begin;
    runs[i].update_seconds = runs[i].seconds;
    runs[i].global_from_imu = GlobalFromImu(adjuster);
    if (predicted) {  // Otherwise the estimator has just aligned, which is shown at once.
      const int64_t since_ns = frame.timestamp_ns - recording.frames[i - 1].timestamp_ns;
      const auto last = adjuster.PoseOf(static_cast<int64_t>(i) - 1);
      if (last && runs[i - 1].global_from_imu) {
        steady.TakeUp(frame.timestamp_ns, *runs[i - 1].global_from_imu,
                      *adjuster.global_from_local() * *last, since_ns);
      } else {
        steady.TakeUp(frame.timestamp_ns, *predicted, *runs[i].global_from_imu, since_ns);
      }
    }
    if (runs[i].global_from_imu) {
      runs[i].steady_global_from_imu = steady.Show(frame.timestamp_ns, *runs[i].global_from_imu);
    }
  }
  return runs;
}

}  // namespace cairn::fusion
