// The relative pose of two photos from their matches. Private to mapping/matching.
#ifndef CAIRN_MAPPING_MATCHING_PAIR_POSE_H_
#define CAIRN_MAPPING_MATCHING_PAIR_POSE_H_

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "mapping/matching/pair_rays.h"
#include "mapping/matching/relative_pose.h"
#include "mapping/matching/two_view.h"

namespace cairn {

// The photo with its camera's focal length multiplied by `focal_factor`. Errors of keypoints count
// as larger if nobody knows the focal length.
RaySource SourceOf(const PhotoSet& set, int photo, double focal_factor);

struct PairPose {
  RefinedRelativePose pose;
  std::vector<int> inliers;  // Of the rays, ascending.
  double score = 0.0;
};

// Nothing if no pose has `options.min_inliers` inliers and a score of more than `score_to_beat`.
// Where most points lie on one plane, the twin (TwinOf) is looked at, too, and the pose is the one
// that has more points in front of both cameras.
std::optional<PairPose> FindPairPose(std::span<const RayMatch> rays, const TwoViewOptions& options,
                                     double score_to_beat, uint64_t seed);

// The pose, refined on its inliers among the rays until these stay the same, three times at most.
// Nothing if fewer than `min_inliers` remain.
std::optional<PairPose> SettlePose(std::span<const RayMatch> rays, const Rigid3d& b_from_a,
                                   int min_inliers);

// A two view without photos and focal lengths. Its pose is that of `found`, refined with the errors
// that the inliers show (NoiseOf) on all rays within four of these; its inliers stay those of
// `found`. `matches` are those that the rays were made of.
TwoView MakeTwoView(const PairRays& rays, const PairPose& found,
                    std::span<const FeatureMatch> matches);

}  // namespace cairn

#endif  // CAIRN_MAPPING_MATCHING_PAIR_POSE_H_
