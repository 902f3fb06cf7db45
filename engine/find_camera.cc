#include "engine/find_camera.h"

#include "engine/find_candidates.h"
#include "engine/focal/focal_refinement.h"
#include "engine/focal/focal_search.h"
#include "engine/pose/estimate_candidate_poses.h"
#include "engine/query/build_query_context.h"

namespace cairn {

QueryContext FindCamera(const QueryContext& stated, const LocalizeQuery& query,
                        const std::vector<TileView>& tiles, const SharedMatches& matches,
                        const LocalizerOptions& options, const QueryBudget& budget,
                        StageCounters* counters) {
  constexpr int kNumRefined = 2;
  const CameraPrior prior = CameraPriorOf(query);
  FocalSearch search(prior.focal, options.refinement.good_evidence);
  PoseHypotheses hypotheses;
  Camera best_camera = prior.camera;
  double best_score = 0.0;
  while (const auto factor = budget.DeadlinePassed() ? std::nullopt : search.Next()) {
    const QueryContext scaled = WithCamera(stated, WithFocalScaled(prior.camera, *factor));
    EstimateCandidatePoses(scaled, matches,
                           FindCandidates(scaled, tiles, *matches, options, budget, counters),
                           options.pose, options.seed, budget, &hypotheses, counters);
    double score = 0.0;
    for (const PoseHypothesis* pose : hypotheses.Best(kNumRefined)) {
      if (pose->estimate.evidence < kMinShareOfBest * best_score) {
        continue;
      }
      const auto refined =
          RefineWithCamera(scaled, *pose->correspondences, pose->estimate, prior, options.pose);
      if (refined && refined->estimate.evidence > score) {
        score = refined->estimate.evidence;
        if (score > best_score) {
          best_score = score;
          best_camera = refined->camera.camera;
        }
      }
    }
    search.Report(score);
    hypotheses.DropPoses();
  }
  return WithCamera(stated, best_camera);
}

}  // namespace cairn
