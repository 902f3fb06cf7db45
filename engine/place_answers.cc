#include "engine/place_answers.h"

#include <algorithm>
#include <utility>

#include "core/check.h"

namespace cairn {
namespace {

// Orders answers: higher scores first, then the reasons that are nearer to an answer, which stand
// later in the enumeration.
bool IsBetter(const LocalizeResult& a, const LocalizeResult& b) {
  if (a.localized != b.localized) {
    return a.localized;
  }
  return a.localized ? a.score > b.score : a.reason > b.reason;
}

bool AreTwoPlaces(const LocalizeResult& a, const LocalizeResult& b, const AnswerOptions& options) {
  const Rigid3d &a_pose = a.cam_from_ecef, &b_pose = b.cam_from_ecef;
  return (a_pose.Inverse().translation - b_pose.Inverse().translation).norm() >
             options.ambiguous_distance_m ||
         RotationAngleRad(a_pose.rotation, b_pose.rotation) > options.ambiguous_rotation_rad;
}

LocalizeResult WithoutPose(const LocalizeResult& answer, NotLocalizedReason reason) {
  LocalizeResult result;
  result.reason = reason;
  result.map_version = answer.map_version;
  result.map_is_stale = answer.map_is_stale;
  result.tiles = answer.tiles;
  result.counters = answer.counters;
  return result;
}

}  // namespace

void PlaceAnswers::Add(double num_votes, LocalizeResult answer) {
  timed_out_ |= answer.reason == NotLocalizedReason::kTimeout;
  if (convincing_num_votes_ < 0.0 && answer.localized &&
      answer.confidence >= options_.places.convincing_confidence) {
    convincing_num_votes_ = num_votes;
  }
  tiles_.insert(answer.tiles.begin(), answer.tiles.end());
  answers_.push_back(std::move(answer));
}

bool PlaceAnswers::AreEnough(double next_num_votes) const {
  constexpr double kShareOfRival = 0.7;
  return timed_out_ || next_num_votes < kShareOfRival * convincing_num_votes_;
}

LocalizeResult PlaceAnswers::Best() const {
  CAIRN_CHECK(!answers_.empty(), "no place was searched");
  const LocalizeResult& best = *std::min_element(answers_.begin(), answers_.end(), IsBetter);
  const bool is_ambiguous =
      best.localized && std::any_of(answers_.begin(), answers_.end(), [&](const auto& rival) {
        return rival.localized &&
               rival.score >= options_.answer.ambiguous_score_ratio * best.score &&
               AreTwoPlaces(rival, best, options_.answer);
      });
  LocalizeResult result = is_ambiguous ? WithoutPose(best, NotLocalizedReason::kAmbiguous) : best;
  result.counters.num_places_searched = static_cast<int64_t>(answers_.size());
  result.counters.num_tiles_searched = static_cast<int64_t>(tiles_.size());
  result.counters.num_tiles_loaded = 0;
  result.times = {};
  for (const LocalizeResult& answer : answers_) {
    result.counters.num_tiles_loaded += answer.counters.num_tiles_loaded;
    result.counters.tiles_cut_short |= answer.counters.tiles_cut_short;
    for (int stage = 0; stage < kNumStages; ++stage) {
      result.times.seconds[stage] += answer.times.seconds[stage];
    }
  }
  return result;
}

}  // namespace cairn
