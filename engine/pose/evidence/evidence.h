// How improbable it is that chance explains the inliers of a pose.
#ifndef CAIRN_ENGINE_POSE_EVIDENCE_EVIDENCE_H_
#define CAIRN_ENGINE_POSE_EVIDENCE_EVIDENCE_H_

#include <optional>
#include <vector>

#include "core/rigid3.h"
#include "engine/pose/evidence/evidence_model.h"
#include "engine/query/inlier_traits.h"
#include "engine/query/query_context.h"

namespace cairn {

struct PoseEvidence {
  // Logarithm of the likelihood ratio of "the pose is right" against "all matches fell by chance",
  // of what independent inliers say. Were matches independent, a given pose would reach s by chance
  // with a probability of at most exp(-s).
  double log_ratio = 0.0;
  // For each inlier the probability that its match is right, if the pose is.
  std::vector<double> right_probabilities;
};

// The evidence of `inliers`, indices into the correspondences, at most one of a keypoint. The
// correspondences are all that the pose was looked for in: each is a chance to agree with it.
//
// Under "chance" the landmark of a match falls anywhere in the image, by LandmarkDensity; under
// "right" a share p of the keypoints has a right match, whose error and traits follow the model.
// The logarithm is
//   max over p of   sum over keypoints of log(1 - p + p r),
// r being the likelihood ratio of the keypoint's inlier over the number of its matches, or 0. It is
// multiplied by the share of the image's area that likely inliers cover of the area that they would
// cover if they were apart, see EffectiveInliers: neighbours are not independent. Linear in the
// correspondences.
PoseEvidence WeighEvidence(const QueryContext& query,
                           const std::vector<Correspondence>& correspondences,
                           const std::vector<int>& inliers, const Rigid3d& cam_from_anchor,
                           const EvidenceModel& model);

// Logarithm of the density of a right match's error, per square pixel.
double LogErrorDensity(const InlierTraits& traits, const EvidenceModel& model);
// Logarithm of the likelihood ratio of everything but the error.
double LogTraitRatio(const InlierTraits& traits, const EvidenceModel& model);

// Nothing if the landmark does not project.
std::optional<InlierTraits> TraitsOf(const QueryContext& query, const Correspondence& match,
                                     const Rigid3d& cam_from_anchor);

}  // namespace cairn

#endif  // CAIRN_ENGINE_POSE_EVIDENCE_EVIDENCE_H_
