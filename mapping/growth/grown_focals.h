// Focal lengths that segments tell better than the two views from which they grew.
#ifndef CAIRN_MAPPING_GROWTH_GROWN_FOCALS_H_
#define CAIRN_MAPPING_GROWTH_GROWN_FOCALS_H_

#include <optional>
#include <span>
#include <vector>

#include "mapping/photo_set.h"
#include "mapping/segment.h"

namespace cairn {

// Returns nothing if no focal length has moved far, else the cameras of the set from which to grow
// again. A camera whose focal length was a guess, or told by photos, has that of its largest
// segment if this has ten of its photos or more and moved the focal length by a tenth or more; the
// source is then kGrowth. If the segment found a distortion that widens the corners as no lens in
// use does, the focal length is a third shorter still: one that is too long and the distortion make
// up for each other.
//
// Along a drive that looks ahead, pairs of photos hardly tell the focal length, and photos that are
// fitted under a wrong one bend the segment, or are fitted at a wrong place. The same photos
// matched and grown again from the focal length of the bent segment agree.
std::optional<std::vector<MappingCamera>> GrownFocals(const PhotoSet& set,
                                                      std::span<const Segment> segments);

}  // namespace cairn

#endif  // CAIRN_MAPPING_GROWTH_GROWN_FOCALS_H_
