// Decides how many of a query's keypoints are matched before an answer is tried.
#ifndef CAIRN_ENGINE_ROUNDS_H_
#define CAIRN_ENGINE_ROUNDS_H_

#include "engine/answer/answer_options.h"
#include "engine/pose/pose_hypotheses.h"

namespace cairn {

// Returns the number of keypoints of the first round: an eighth of them, at least 128, because
// matching visits the map for all keypoints of a round together.
int FirstRound(int num_keypoints);

// Returns true if the search may end although some keypoints have not been matched: the best pose
// has at least `sure_evidence` and the consensus of enough keypoints to see a rival, and no pose
// far from it (AnswerOptions) has a share of its evidence.
bool IsBeyondDoubt(const PoseHypotheses& hypotheses, double sure_evidence,
                   const AnswerOptions& options);

// Returns the number of keypoints, in all, of the round after one that was in doubt: as many as the
// best pose needs to be sure if its evidence grows as it did so far. Returns num_keypoints if these
// are about as many, or if there is no pose that evidence could make sure.
int NextRound(int num_matched, int num_keypoints, const PoseHypotheses& hypotheses,
              double sure_evidence);

}  // namespace cairn

#endif  // CAIRN_ENGINE_ROUNDS_H_
