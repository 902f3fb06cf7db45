// From pose hypotheses to the answer: which one wins, whether it may be trusted, what is reported.
#ifndef CAIRN_ENGINE_ANSWER_H_
#define CAIRN_ENGINE_ANSWER_H_

#include <memory>
#include <vector>

#include "engine/localize_result.h"
#include "engine/localizer_options.h"
#include "engine/pose_candidate.h"
#include "engine/query_context.h"
#include "engine/tiles/searchable_tile.h"

namespace cairn {

// A pose and the correspondences its inliers index.
struct PoseHypothesis {
  PoseEstimate estimate;
  std::shared_ptr<const std::vector<Correspondence>> correspondences;
};

// Picks the hypothesis with most effective inliers within the region and fills the result: its
// pose, accuracy, score, confidence and matches; or the reason why there is no answer:
// kPriorMismatch if only poses outside the region are good enough, kAmbiguous, kTooFewInliers.
// `hypotheses` must not be empty.
void ConcludeAnswer(const QueryContext& query, const std::vector<TileView>& tiles,
                    const std::vector<PoseHypothesis>& hypotheses, const AnswerOptions& options,
                    LocalizeResult* result);

// Probability that a pose with this score is within 3 m and 10 degrees of the truth; rises with the
// score. The curve is a logistic in log(score), set by hand so that the acceptance threshold of 8
// effective inliers means 0.7 and 30 mean 0.98; it is not calibrated on a large data set yet.
double ConfidenceOfScore(double effective_inliers);

}  // namespace cairn

#endif  // CAIRN_ENGINE_ANSWER_H_
