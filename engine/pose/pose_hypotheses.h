// The poses that a query has found so far.
#ifndef CAIRN_ENGINE_POSE_POSE_HYPOTHESES_H_
#define CAIRN_ENGINE_POSE_POSE_HYPOTHESES_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "engine/query/localize_result.h"
#include "engine/query/pose_candidate.h"
#include "engine/query/query_budget.h"
#include "engine/query/query_context.h"

namespace cairn {

// Matches that several hypotheses share; never null in a hypothesis.
using SharedMatches = std::shared_ptr<const std::vector<Correspondence>>;

// A pose, and the matches into which its inliers index.
struct PoseHypothesis {
  PoseEstimate estimate;
  SharedMatches correspondences;
  bool used_gravity = false;
  std::optional<CameraEstimate> camera;  // As LocalizeResult::camera.
};

// An attempt to find a pose, with the matches it searched. `correspondences` is null if the
// deadline had passed.
struct PoseAttempt {
  SharedMatches correspondences;
  std::optional<PoseEstimate> estimate;
};

// What attempts have taken.
struct AttemptCount {
  int num_made = 0;  // Those that the deadline did not leave out.
  int64_t num_ransac_iterations = 0;
};

// A pose with a smaller share of the best pose's evidence can neither win nor make the answer
// ambiguous.
inline constexpr double kMinShareOfBest = 0.5;

class PoseHypotheses {
 public:
  const std::vector<PoseHypothesis>& all() const { return all_; }
  bool empty() const { return all_.empty(); }

  // Returns the `count` hypotheses with the most evidence, best first; fewer if there are fewer.
  std::vector<const PoseHypothesis*> Best(int count) const;
  bool AnyHasEvidence(double min_evidence) const;

  // Makes attempts 0 ... count - 1 until the deadline and keeps the poses they find. The second
  // argument of `attempt` is the consensus below which a pose is useless.
  AttemptCount TryInRounds(int count, bool use_gravity, const QueryBudget& budget,
                           const std::function<PoseAttempt(int, double)>& attempt);

  // Drops the poses. The consensus of the best remains the bar for later attempts.
  void DropPoses() { all_.clear(); }

 private:
  std::vector<PoseHypothesis> all_;
  double best_consensus_ = 0.0;
};

// What a stage has made of the hypotheses that it was given.
struct TriedPoses {
  PoseHypotheses hypotheses;  // Those that were given, and those of the stage.
  AttemptCount count;
  bool is_complete = true;  // The deadline left out nothing.
};

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_POSE_HYPOTHESES_H_
