// When two photos see the same ground. Private to ingest.
#ifndef CAIRN_INGEST_TILES_NEAR_VIEW_H_
#define CAIRN_INGEST_TILES_NEAR_VIEW_H_

namespace cairn {

// Two photos see the same ground if they stand within this distance, and look within this angle, of
// each other. A map should recognize a photo that sees the ground of one of its own photos.
inline constexpr double kNearViewM = 8.0;
inline constexpr double kNearViewRad = 0.7;  // 40 degrees.

}  // namespace cairn

#endif  // CAIRN_INGEST_TILES_NEAR_VIEW_H_
