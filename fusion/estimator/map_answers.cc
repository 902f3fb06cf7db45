#include "fusion/estimator/map_answers.h"

#include <algorithm>
#include <cmath>

#include "fusion/map_updates/alignment.h"
#include "fusion/tracks/track_update.h"

namespace cairn::fusion {
namespace {

constexpr size_t kMinQueryFeatures = 20;  // A frame with fewer features is not queried.
// Largest angle between an answer's vertical and the filter's gravity: 5 degrees.
constexpr double kMaxTiltRad = 0.0873;

bool IsFinite(const Answer& answer) {
  const Rigid3d& pose = answer.global_from_cam;
  return pose.rotation.coeffs().allFinite() && pose.translation.allFinite() &&
         std::abs(pose.rotation.norm() - 1.0) < 1e-3 &&
         std::all_of(answer.matches.begin(), answer.matches.end(), [](const MapMatch& match) {
           return match.pixel.allFinite() && match.x_in_global.allFinite() &&
                  std::isfinite(match.sigma_m) && match.sigma_m >= 0.0;
         });
}

// Returns why an answer cannot be used, whatever the state; nothing if it can.
std::optional<AnswerOutcome> Refusal(const Answer& answer) {
  if (!answer.localized) {
    return AnswerOutcome::kNotLocalized;
  }
  if (!IsFinite(answer)) {
    return AnswerOutcome::kBadInput;
  }
  if (static_cast<int>(answer.matches.size()) < kMinMapMatches) {
    return AnswerOutcome::kTooFewMatches;
  }
  return std::nullopt;
}

std::vector<TrackedFeature> FeaturesOf(int64_t frame_id, const TrackTable& tracks) {
  std::vector<TrackedFeature> features;
  for (const Track& track : tracks.tracks()) {
    if (!track.observations.empty() && track.observations.back().frame_id == frame_id) {
      features.push_back({track.track_id, track.observations.back().pixel});
    }
  }
  return features;
}

// Fills in the pose of the newest clone, as far as the state knows it.
void FillPose(const FilterState& state, Query* query) {
  const int newest = static_cast<int>(state.clones().size()) - 1;
  const Eigen::Quaterniond cam_from_local =
      state.rig().cam_from_imu.rotation * state.clones().back().local_from_imu.rotation.conjugate();
  query->down_in_cam = cam_from_local * -Eigen::Vector3d::UnitZ();
  query->down_sigma_rad =
      std::sqrt(state.covariance().diagonal().segment<2>(state.CloneIdx(newest)).maxCoeff());
  if (state.global_from_local()) {
    query->prior = CameraPrior(state, newest);
  }
}

const Clone& CloneOf(const FilterState& state, int64_t frame_id) {
  return state.clones()[static_cast<size_t>(FindClone(state, frame_id))];
}

}  // namespace

MapAnswers::MapAnswers(const FusionOptions& options)
    : queries_(options.query), updates_(options.camera, options.map) {}

void MapAnswers::Restart() {
  queries_.Restart();
  candidates_.Release();
  contradictions_.Clear();
  updates_.Clear();
  last_applied_ns_.reset();
}

bool MapAnswers::NeedsFrame(int64_t frame_id) const {
  return queries_.HasFrame(frame_id) || candidates_.HasFrame(frame_id);
}

std::optional<Query> MapAnswers::Poll(const FilterState& state, TrackTable* tracks) {
  if (state.clones().empty() || !queries_.IsDue(state.clones().back().timestamp_ns)) {
    return std::nullopt;
  }
  const Clone& clone = state.clones().back();
  Query query;
  query.features = FeaturesOf(clone.frame_id, *tracks);
  if (query.features.size() < kMinQueryFeatures) {
    return std::nullopt;
  }
  query.query_id = queries_.Ask(clone.frame_id, clone.timestamp_ns);
  query.timestamp_ns = clone.timestamp_ns;
  FillPose(state, &query);
  tracks->SetReserved(clone.frame_id, true);
  return query;
}

AlignmentCounts MapAnswers::TakeUp(int64_t now_ns, FilterState* state, TrackTable* tracks) {
  for (const int64_t frame_id : queries_.Expire(now_ns)) {
    tracks->SetReserved(frame_id, false);
  }
  AlignmentCounts counts;
  for (const Answer& answer : box_.TakeAll()) {
    const std::optional<int64_t> frame_id = queries_.TakeFrame(answer.query_id);
    if (!frame_id) {
      const bool has_expired = queries_.HasExpired(answer.query_id);
      box_.Report({answer.query_id,
                   has_expired ? AnswerOutcome::kCloneGone : AnswerOutcome::kUnknownQuery, 0});
      continue;
    }
    const AnswerReport report = TakeUpOne(answer, *frame_id, {now_ns, state, tracks}, &counts);
    if (report.outcome != AnswerOutcome::kAwaitsAlignment) {
      tracks->SetReserved(*frame_id, false);
    }
    box_.Report(report);
  }
  return counts;
}

AnswerReport MapAnswers::TakeUpOne(const Answer& answer, int64_t frame_id, const Target& target,
                                   AlignmentCounts* counts) {
  if (const auto refusal = Refusal(answer)) {
    return {answer.query_id, *refusal, 0};
  }
  const FilterState& state = *target.state;
  const Rigid3d& local_from_imu = CloneOf(state, frame_id).local_from_imu;
  const Rigid3d global_from_local =
      answer.global_from_cam * state.rig().cam_from_imu * local_from_imu.Inverse();
  const auto [level, tilt_rad] = Level(global_from_local, local_from_imu.translation);
  if (tilt_rad > kMaxTiltRad) {
    return {answer.query_id, AnswerOutcome::kGravityMismatch, 0};
  }
  if (state.global_from_local()) {
    return Apply(answer, frame_id, level, target, counts);
  }
  return {answer.query_id, AwaitAlignment({frame_id, level, answer.matches}, target, counts), 0};
}

AnswerReport MapAnswers::Apply(const Answer& answer, int64_t frame_id, const Rigid3d& level,
                               const Target& target, AlignmentCounts* counts) {
  const MapUpdateResult result =
      updates_.Update(answer.matches, frame_id, target.state, target.tracks);
  if (result.status == MapUpdateStatus::kApplied) {
    last_applied_ns_ = target.now_ns;
    contradictions_.Clear();
    return {answer.query_id, AnswerOutcome::kApplied, result.num_matches};
  }
  if (result.status == MapUpdateStatus::kTooFewMatches) {
    return {answer.query_id, AnswerOutcome::kTooFewMatches, 0};
  }
  if (contradictions_.Add(CloneOf(*target.state, frame_id).timestamp_ns, level,
                          target.state->imu().local_from_imu.translation)) {
    ForgetAlignment(target);
    ++counts->num_realignments;
  }
  return {answer.query_id, AnswerOutcome::kDisagrees, 0};
}

void MapAnswers::ForgetAlignment(const Target& target) {
  target.state->ForgetGlobal();
  for (Track& track : target.tracks->tracks()) {
    track.map_distance.reset();
  }
  updates_.Clear();
  last_applied_ns_.reset();
}

AnswerOutcome MapAnswers::AwaitAlignment(AlignmentCandidate candidate, const Target& target,
                                         AlignmentCounts* counts) {
  if (const auto oldest = candidates_.Add(std::move(candidate))) {
    target.tracks->SetReserved(*oldest, false);
  }
  if (!TryAlign(target)) {
    return AnswerOutcome::kAwaitsAlignment;
  }
  for (const int64_t frame_id : candidates_.Release()) {
    target.tracks->SetReserved(frame_id, false);
  }
  last_applied_ns_ = target.now_ns;
  ++counts->num_alignments;
  return AnswerOutcome::kApplied;
}

bool MapAnswers::TryAlign(const Target& target) {
  const std::vector<const AlignmentCandidate*> agreeing =
      candidates_.Agreeing(target.state->imu().local_from_imu.translation);
  // One frame alone first: global_from_local takes up all the drift of its clone, so that the
  // clones' errors cannot pass for wrong matches. The other answers follow as updates, gated by all
  // that is then known.
  if (agreeing.empty() ||
      !updates_.Align(agreeing.back()->matches, agreeing.back()->frame_id,
                      agreeing.back()->global_from_local, target.state, target.tracks)) {
    return false;
  }
  for (auto other = agreeing.rbegin() + 1; other != agreeing.rend(); ++other) {
    updates_.Update((*other)->matches, (*other)->frame_id, target.state, target.tracks);
  }
  return true;
}

}  // namespace cairn::fusion
