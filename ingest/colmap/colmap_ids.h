// Ids that the written models and databases share; private to ingest/colmap.
#ifndef CAIRN_INGEST_COLMAP_COLMAP_IDS_H_
#define CAIRN_INGEST_COLMAP_COLMAP_IDS_H_

#include <cstdint>

namespace cairn {

// COLMAP's ids start at 1. These constants differ, so that mixed-up ids are noticed.
inline constexpr uint32_t kFirstColmapCameraId = 3;
inline constexpr uint32_t kFirstColmapImageId = 11;
inline constexpr uint64_t kFirstColmapPointId = 1;

}  // namespace cairn

#endif  // CAIRN_INGEST_COLMAP_COLMAP_IDS_H_
