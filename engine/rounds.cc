#include "engine/rounds.h"

#include <algorithm>
#include <cmath>

#include "engine/answer/answer.h"

namespace cairn {
namespace {

// A rival that has four fifths of the best pose's evidence, which is what makes an answer
// ambiguous, has less than half of its consensus among the keypoints of a round by chance: a
// binomial of 24 with 0.8 is below 12 with a probability of 2e-4.
constexpr double kMinConsensus = 24.0;

}  // namespace

int FirstRound(int num_keypoints) {
  constexpr int kShare = 8, kMinKeypoints = 128;
  return std::min(num_keypoints, std::max(kMinKeypoints, num_keypoints / kShare));
}

bool IsBeyondDoubt(const PoseHypotheses& hypotheses, double sure_evidence,
                   const AnswerOptions& options) {
  constexpr double kMaxRivalShare = 0.25;
  if (!hypotheses.AnyHasEvidence(sure_evidence)) {
    return false;
  }
  const PoseEstimate& best = hypotheses.Best(1).front()->estimate;
  return best.consensus >= kMinConsensus &&
         std::none_of(
             hypotheses.all().begin(), hypotheses.all().end(), [&](const PoseHypothesis& other) {
               return other.estimate.evidence >= kMaxRivalShare * best.evidence &&
                      AreFarApart(best.cam_from_anchor, other.estimate.cam_from_anchor, options);
             });
}

int NextRound(int num_matched, int num_keypoints, const PoseHypotheses& hypotheses,
              double sure_evidence) {
  constexpr double kMargin = 1.3;     // Evidence grows more slowly than the number of keypoints.
  constexpr double kMinGrowth = 1.5;  // A smaller round costs as much again for less.
  constexpr double kMaxShare = 0.6;   // A larger round saves too little.
  if (hypotheses.empty()) {
    return num_keypoints;
  }
  const PoseEstimate& best = hypotheses.Best(1).front()->estimate;
  if (best.evidence <= 0.0 || best.consensus <= 0.0) {
    return num_keypoints;
  }
  const double growth =
      kMargin * std::max(sure_evidence / best.evidence, kMinConsensus / best.consensus);
  const double needed = std::max(growth, kMinGrowth) * num_matched;
  return needed > kMaxShare * num_keypoints ? num_keypoints : static_cast<int>(std::ceil(needed));
}

}  // namespace cairn
