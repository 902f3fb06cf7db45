// Photos of one segment in another.
#ifndef CAIRN_MAPPING_GROWTH_SEGMENT_GUESTS_H_
#define CAIRN_MAPPING_GROWTH_SEGMENT_GUESTS_H_

#include <span>

#include "mapping/growth/growth_scene.h"
#include "mapping/segment.h"

namespace cairn {

// The segment and, of the photos at the other ends of these two views, those that it localizes by
// the rules of growth. Indices are those of the scene's graph. Two parts of a walk may share no
// point that two photos of each see; with the photos on the border in both parts, they do.
Segment WithGuests(const GrowthScene& scene, const Segment& host, std::span<const int> views);

}  // namespace cairn

#endif  // CAIRN_MAPPING_GROWTH_SEGMENT_GUESTS_H_
