// Measures how unlikely it is that a pose has its inliers by chance.
#ifndef CAIRN_ENGINE_POSE_EVIDENCE_H_
#define CAIRN_ENGINE_POSE_EVIDENCE_H_

#include <optional>
#include <vector>

#include "core/rigid3.h"
#include "engine/query/inlier_traits.h"
#include "engine/query/query_context.h"

namespace cairn {

struct PoseEvidence {
  // Logarithm of the likelihood ratio of "the pose is right" against "all matches agree by chance",
  // reduced to independent inliers. If matches were independent, a given pose would reach s by
  // chance with a probability of at most exp(-s).
  double log_ratio = 0.0;
  // For each inlier, the probability that its match is right if the pose is right.
  std::vector<double> right_probabilities;
};

// Computes the evidence of `inliers`, which are indices into the correspondences, at most one per
// keypoint. `correspondences` must be all those among which the pose was searched, since each of
// them is a chance to agree with the pose.
//
// Under "chance", the landmark of a match falls anywhere in the image, with the density
// LandmarkDensity; or, if the match was sought given a pose, anywhere in the area of the search
// (Correspondence::search_area_sq_px), so that it says less. Under "right", a share p of the
// keypoints has a right match, whose error and traits follow kEvidenceModel. The logarithm is
//   max over p of   sum over keypoints of log(1 - p + p r),
// where r is the likelihood ratio of the keypoint's inlier divided by the number of its matches, or
// 0 without an inlier. Neighboring inliers are not independent, so the logarithm is multiplied by
// the area that likely inliers cover, as a share of the area that they would cover if they were
// apart (see EffectiveInliers). Linear in the correspondences.
PoseEvidence WeighEvidence(const QueryContext& query,
                           const std::vector<Correspondence>& correspondences,
                           const std::vector<int>& inliers, const Rigid3d& cam_from_anchor);

// Returns the logarithm of the density of a right match's error, per square pixel.
double LogErrorDensity(const InlierTraits& traits);
// Returns the logarithm of the likelihood ratio of all traits except the error.
double LogTraitRatio(const InlierTraits& traits);

// Returns nothing if the landmark does not project.
std::optional<InlierTraits> TraitsOf(const QueryContext& query, const Correspondence& match,
                                     const Rigid3d& cam_from_anchor);

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_EVIDENCE_H_
