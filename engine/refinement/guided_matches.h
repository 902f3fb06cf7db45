// Matches that a known pose makes easy to find: each landmark is compared only with the keypoints
// where the camera should see it.
#ifndef CAIRN_ENGINE_REFINEMENT_GUIDED_MATCHES_H_
#define CAIRN_ENGINE_REFINEMENT_GUIDED_MATCHES_H_

#include <vector>

#include "engine/pose/pose_options.h"
#include "engine/query/pose_candidate.h"
#include "engine/query/query_context.h"
#include "engine/tiles/searchable_tile.h"

namespace cairn {

// Projects the landmarks of the keyframes nearest to the pose. A landmark is compared with the
// keypoints within the threshold of an inlier, widened by twice the standard deviation that the
// pose's covariance gives its projection. Of the landmarks whose size fits, a keypoint matches the
// one with the nearest descriptor, up to the 0.95-quantile of the same-landmark distances. A
// landmark in several tiles is compared in each of them. Returns the matches in order of keypoint.
// They know the area that was searched, so that they count as evidence for no more than they say
// (Correspondence::search_area_sq_px).
//
// Needs no index, so it takes a few dozen descriptor distances a landmark, whatever the size of the
// map.
std::vector<Correspondence> GuidedMatches(const QueryContext& query,
                                          const std::vector<TileView>& tiles,
                                          const PoseEstimate& estimate, const PoseOptions& options);

}  // namespace cairn

#endif  // CAIRN_ENGINE_REFINEMENT_GUIDED_MATCHES_H_
