// Photos of one segment in another.
#ifndef CAIRN_MAPPING_GROWTH_SEGMENT_GUESTS_H_
#define CAIRN_MAPPING_GROWTH_SEGMENT_GUESTS_H_

#include <optional>
#include <span>

#include "mapping/growth/growth_scene.h"
#include "mapping/segment.h"

namespace cairn {

// The host and, of the photos of `other` that these two views link with it, those that join by the
// rules of growth; nothing if none does. `views` are indices of the scene's graph. Two parts of a
// walk may share no point that two photos of each see; with the photos on the border in both parts,
// they do. Copies the host.
std::optional<Segment> WithGuests(const GrowthScene& scene, const Segment& host,
                                  const Segment& other, std::span<const int> views);

}  // namespace cairn

#endif  // CAIRN_MAPPING_GROWTH_SEGMENT_GUESTS_H_
