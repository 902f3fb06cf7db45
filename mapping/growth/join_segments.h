// Joins segments that show the same, though no photo of one could join the other alone.
#ifndef CAIRN_MAPPING_GROWTH_JOIN_SEGMENTS_H_
#define CAIRN_MAPPING_GROWTH_JOIN_SEGMENTS_H_

#include <vector>

#include "mapping/growth/grow_segments.h"
#include "mapping/growth/growth_scene.h"
#include "mapping/segment.h"

namespace cairn {

// Tries pairs of segments that two views link, those with the most inliers first, until no pair
// joins any more; then segments that joined grow on, and the pairs that changed are tried again.
// Two segments become one if (decision 66):
// - enough tracks agree on a similarity (AlignSegments); if not, photos of each segment that join
//   the other count as photos of both (WithGuests),
// - in the adjusted union, the inliers of most two views between them fit: those of at least three
//   two views, with two photos on each side, and four times the inliers of those that do not fit;
//   twice, if positions tell the places of both segments,
// - two of these two views are as strong as GrowthOptions::min_link_share asks, compared with the
//   strongest two views that both their photos have within their segments: a copy of a facade is
//   linked more weakly,
// - the positions show no step and do not err much more than in the segments alone,
// - of each segment, nine tenths of the photos or all but one are not contradicted by positions and
//   keep GrowthOptions::min_inliers observations.
// Segments that do not join stay as they were. A photo that leaves gets a verdict. Deterministic.
void JoinSegments(const GrowthScene& scene, std::vector<Segment>* segments,
                  std::vector<PhotoVerdict>* verdicts);

}  // namespace cairn

#endif  // CAIRN_MAPPING_GROWTH_JOIN_SEGMENTS_H_
