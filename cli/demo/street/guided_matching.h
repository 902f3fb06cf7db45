// Matches two images with known poses along their epipolar lines.
#ifndef CAIRN_CLI_DEMO_STREET_GUIDED_MATCHING_H_
#define CAIRN_CLI_DEMO_STREET_GUIDED_MATCHING_H_

#include <vector>

#include "cli/demo/street/posed_features.h"
#include "core/scene/tracks.h"

namespace cairn {

// Returns the mutually best matches that pass the ratio test, ordered by a_idx. Sorts the planes
// through both camera centers by their angle about the baseline, so that each keypoint is compared
// only with candidates on its own epipolar line. Takes O(n log n) time and a few dozen descriptor
// distances per keypoint.
std::vector<FeatureMatch> MatchAlongEpipolarLines(const PosedFeatures& a, const PosedFeatures& b);

}  // namespace cairn

#endif  // CAIRN_CLI_DEMO_STREET_GUIDED_MATCHING_H_
