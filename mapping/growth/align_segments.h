// The similarity between two segments that see the same points.
#ifndef CAIRN_MAPPING_GROWTH_ALIGN_SEGMENTS_H_
#define CAIRN_MAPPING_GROWTH_ALIGN_SEGMENTS_H_

#include <cstdint>
#include <optional>

#include "core/rigid3.h"
#include "mapping/growth/draft.h"
#include "mapping/segment.h"

namespace cairn {

struct SegmentAlignment {
  Sim3d b_from_a;        // From the world of one segment to that of the other.
  int num_agreeing = 0;  // Points.
  int num_shared = 0;    // Tracks that have a landmark in both segments.
};

// Finds the similarity on which the most tracks agree that have a landmark in both segments. A
// landmark of one segment must lie where the photos of the other see it, within four standard
// deviations of the landmark and of twice the pixel: neither segment is adjusted to the other.
// RANSAC draws three landmarks that one photo of the other segment sees: P3P gives the place of the
// photo, and the depths in both worlds give the scale. Nothing if fewer than `min_points` agree.
// Deterministic by seed. [The formulas](../../docs/math/mapping.md#segments-that-meet).
std::optional<SegmentAlignment> AlignSegments(const TrackTable& tracks, const Segment& a,
                                              const Segment& b, int min_points, uint64_t seed);

}  // namespace cairn

#endif  // CAIRN_MAPPING_GROWTH_ALIGN_SEGMENTS_H_
