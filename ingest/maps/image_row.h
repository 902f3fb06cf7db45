// A mapping image as shards and built tiles store it; private to ingest.
#ifndef CAIRN_INGEST_MAPS_IMAGE_ROW_H_
#define CAIRN_INGEST_MAPS_IMAGE_ROW_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "storage/map/map_store.h"
#include "storage/tile/byte_io.h"

namespace cairn {

// The least bytes of a row: counts are checked against it before memory is allocated.
inline constexpr size_t kMinImageRowBytes = 90;

// Session and tile are those of the file, and not part of the row.
void PutImageRow(const KeyframeRecord& keyframe, ByteWriter* writer);

// Leaves session and tile empty. Throws Error(kMapDamaged) or Error(kBadInput) unless the id is
// positive, the pose rigid and the camera one.
KeyframeRecord GetImageRow(ByteReader* reader);

// Reads `count` rows. Throws as GetImageRow.
std::vector<KeyframeRecord> GetImageRows(size_t count, ByteReader* reader);

}  // namespace cairn

#endif  // CAIRN_INGEST_MAPS_IMAGE_ROW_H_
