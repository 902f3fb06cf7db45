#include "lab/rivals/fusion/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/angles.h"
#include "core/error.h"
#include "lab/rivals/fusion/run_estimators.h"

namespace cairn::fusion {
namespace {

Spread SpreadOf(const std::vector<double>& values) {
  if (values.empty()) {
    return {};
  }
  const auto count = static_cast<double>(values.size());
  Spread spread;
  for (const double value : values) {
    spread.mean += value / count;
  }
  double sq_sum = 0.0;
  for (const double value : values) {
    sq_sum += (value - spread.mean) * (value - spread.mean);
  }
  spread.standard_deviation = std::sqrt(sq_sum / count);
  return spread;
}

double Rms(const std::vector<double>& values) {
  double sq_sum = 0.0;
  for (const double value : values) {
    sq_sum += value * value;
  }
  return values.empty() ? 0.0 : std::sqrt(sq_sum / static_cast<double>(values.size()));
}

Smoothness SmoothnessOf(std::vector<double> changes) {
  if (changes.empty()) {
    return {};
  }
  std::sort(changes.begin(), changes.end());
  const auto rank = static_cast<size_t>(0.95 * static_cast<double>(changes.size() - 1));
  return {.rms = Rms(changes), .percentile_95 = changes[rank], .maximum = changes.back()};
}

// Selects one of the poses of a frame.
using PoseOfRun = std::optional<Rigid3d> FrameRun::*;

void SetErrors(const Recording& recording, const std::vector<FrameRun>& runs, PoseOfRun pose_of,
               MethodResult* result) {
  std::vector<double> position_errors, rotation_errors, position_changes, rotation_changes;
  Eigen::Vector3d last_position;
  Eigen::Quaterniond last_rotation;
  bool has_last = false;
  for (size_t i = recording.first_counted_frame; i < runs.size(); ++i) {
    const std::optional<Rigid3d>& global_from_imu = runs[i].*pose_of;
    if (!global_from_imu) {
      has_last = false;
      continue;
    }
    const Rigid3d& truth = recording.frames[i].global_from_imu;
    const Eigen::Vector3d position = global_from_imu->translation - truth.translation;
    const Eigen::Quaterniond rotation = global_from_imu->rotation * truth.rotation.conjugate();
    position_errors.push_back(position.norm());
    rotation_errors.push_back(LogSo3(rotation).norm());
    if (has_last) {
      position_changes.push_back((position - last_position).norm());
      rotation_changes.push_back(LogSo3(rotation * last_rotation.conjugate()).norm());
    }
    last_position = position;
    last_rotation = rotation;
    has_last = true;
  }
  result->num_counted_frames = position_errors.size();
  result->position_rmse_m = Rms(position_errors);
  result->rotation_rmse_rad = Rms(rotation_errors);
  result->position_error_m = SpreadOf(position_errors);
  result->rotation_error_rad = SpreadOf(rotation_errors);
  result->position_change_m = SmoothnessOf(std::move(position_changes));
  result->rotation_change_rad = SmoothnessOf(std::move(rotation_changes));
}

void SetTimes(const Recording& recording, const std::vector<FrameRun>& runs, MethodResult* result) {
  std::vector<double> of_frames, of_updates;
  double num_matches = 0.0;
  for (size_t i = recording.first_counted_frame; i < runs.size(); ++i) {
    if (runs[i].had_answer) {
      of_frames.push_back(runs[i].seconds);
      of_updates.push_back(runs[i].update_seconds);
    }
    num_matches += runs[i].num_matches;
  }
  result->frame_seconds = SpreadOf(of_frames);
  result->update_seconds = SpreadOf(of_updates);
  result->mean_matches =
      of_frames.empty() ? 0.0 : num_matches / static_cast<double>(of_frames.size());
}

// Runs several times and keeps each frame's fastest time.
template <typename Run>
std::vector<FrameRun> Repeat(int num_timings, const Run& run) {
  std::vector<FrameRun> runs = run();
  for (int repetition = 1; repetition < num_timings; ++repetition) {
    const std::vector<FrameRun> again = run();
    for (size_t i = 0; i < runs.size(); ++i) {
      runs[i].seconds = std::min(runs[i].seconds, again[i].seconds);
      runs[i].update_seconds = std::min(runs[i].update_seconds, again[i].update_seconds);
    }
  }
  return runs;
}

MethodResult Summarize(std::string name, const Recording& recording,
                       const std::vector<FrameRun>& runs) {
  MethodResult result;
  result.name = std::move(name);
  SetErrors(recording, runs, &FrameRun::global_from_imu, &result);
  SetTimes(recording, runs, &result);
  return result;
}

// Summarizes the poses that a display would show; the times are those of `raw`.
MethodResult SummarizeSteady(MethodResult raw, const Recording& recording,
                             const std::vector<FrameRun>& runs) {
  raw.name += ", steady";
  raw.is_steady = true;
  SetErrors(recording, runs, &FrameRun::steady_global_from_imu, &raw);
  return raw;
}

// The ratios of one method to others, as text.
std::string RatioTable(const MethodResult& filter, std::span<const MethodResult> others) {
  std::string text = fmt::format("{:<20}{:>12}{:>14}{:>16}{:>16}{:>18}{:>18}\n", filter.name,
                                 "t-up / it", "frame / it", "it / position", "it / rotation",
                                 "it / change m", "it / change rad");
  for (const MethodResult& r : others) {
    text += fmt::format("{:<20}{:>12.1f}{:>14.1f}{:>16.2f}{:>16.2f}{:>18.2f}{:>18.2f}\n", r.name,
                        r.update_seconds.mean / filter.update_seconds.mean,
                        r.frame_seconds.mean / filter.frame_seconds.mean,
                        filter.position_rmse_m / r.position_rmse_m,
                        filter.rotation_rmse_rad / r.rotation_rmse_rad,
                        filter.position_change_m.rms / r.position_change_m.rms,
                        filter.rotation_change_rad.rms / r.rotation_change_rad.rms);
  }
  return text;
}

}  // namespace

std::string RivalVariant::Name() const {
  return fmt::format("BA-{}-{}{}{}", num_cameras, num_iterations,
                     discard == DiscardPolicy::kMarginalize ? "-M" : "",
                     every_frame_is_keyframe ? "-F" : "");
}

std::vector<RivalVariant> PaperVariants() {
  return {{10, 10, DiscardPolicy::kDiscard},  {10, 5, DiscardPolicy::kDiscard},
          {5, 10, DiscardPolicy::kDiscard},   {5, 5, DiscardPolicy::kDiscard},
          {5, 2, DiscardPolicy::kDiscard},    {10, 5, DiscardPolicy::kMarginalize},
          {5, 2, DiscardPolicy::kMarginalize}};
}

BundleAdjusterOptions RivalOptions(const Recording& recording, const RivalVariant& variant) {
  BundleAdjusterOptions options;
  options.camera = recording.options.camera;
  options.rig = recording.options.rig;
  options.imu_noise = recording.options.imu_noise;
  options.gravity_m_s2 = recording.options.gravity_m_s2;
  options.track_sigma_px = recording.options.tracks.sigma_px;
  options.match_sigma_px = recording.options.map.sigma_px;
  options.triangulate = recording.options.tracks.triangulate;
  options.num_cameras = variant.num_cameras;
  options.num_iterations = variant.num_iterations;
  options.discard = variant.discard;
  return options;
}

void ComparisonOptions::Validate() const {
  if (num_timings < 1) {
    throw Error(ErrorCode::kInvalidArgument, "ComparisonOptions: num_timings must be positive");
  }
}

std::vector<MethodResult> CompareEstimators(const Recording& recording,
                                            const ComparisonOptions& options) {
  options.Validate();
  if (recording.first_counted_frame + 2 > recording.frames.size()) {
    throw Error(ErrorCode::kBadInput,
                "recording " + recording.name + ": fewer than two frames to count");
  }
  const std::vector<FrameRun> of_filter =
      Repeat(options.num_timings, [&] { return RunFilter(recording); });
  std::vector<MethodResult> results = {Summarize("EKF", recording, of_filter)};
  results.push_back(SummarizeSteady(results.front(), recording, of_filter));
  std::vector<MethodResult> steady_rivals;
  for (const RivalVariant& variant : options.variants) {
    const BundleAdjusterOptions rival = RivalOptions(recording, variant);
    const std::vector<FrameRun> runs = Repeat(options.num_timings, [&] {
      return RunBundleAdjuster(recording, rival, variant.every_frame_is_keyframe);
    });
    results.push_back(Summarize(variant.Name(), recording, runs));
    if (options.steadies_rivals) {
      steady_rivals.push_back(SummarizeSteady(results.back(), recording, runs));
    }
  }
  results.insert(results.end(), steady_rivals.begin(), steady_rivals.end());
  return results;
}

std::string ComparisonTable(const std::string& title, std::span<const MethodResult> results) {
  std::string text =
      fmt::format("{}\n{:<20}{:>18}{:>10}{:>9}{:>19}{:>19}{:>24}{:>24}\n", title, "", "t-up ms",
                  "frame ms", "matches", "position m (sd)", "rotation deg (sd)",
                  "change mm rms/95/max", "change mdeg rms/95/max");
  for (const MethodResult& r : results) {
    text += fmt::format(
        "{:<20}{:>9.3f} +-{:>6.3f}{:>10.3f}{:>9.0f}{:>10.4f} ({:.4f}){:>10.4f} ({:.4f})"
        "{:>10.2f}{:>7.2f}{:>7.2f}{:>10.1f}{:>7.1f}{:>7.1f}\n",
        r.name, 1e3 * r.update_seconds.mean, 1e3 * r.update_seconds.standard_deviation,
        1e3 * r.frame_seconds.mean, r.mean_matches, r.position_rmse_m,
        r.position_error_m.standard_deviation, kDegPerRad * r.rotation_rmse_rad,
        kDegPerRad * r.rotation_error_rad.standard_deviation, 1e3 * r.position_change_m.rms,
        1e3 * r.position_change_m.percentile_95, 1e3 * r.position_change_m.maximum,
        1e3 * kDegPerRad * r.rotation_change_rad.rms,
        1e3 * kDegPerRad * r.rotation_change_rad.percentile_95,
        1e3 * kDegPerRad * r.rotation_change_rad.maximum);
  }
  for (const MethodResult& filter : results.first(2)) {
    text += RatioTable(filter, results.subspan(2));
  }
  return text;
}

}  // namespace cairn::fusion
