// Encodes and decodes the shards of a plan. The format is docs/formats/plan_v1.md.
#ifndef CAIRN_INGEST_MAPS_SHARD_CODEC_H_
#define CAIRN_INGEST_MAPS_SHARD_CODEC_H_

#include <cstdint>
#include <span>
#include <vector>

#include "ingest/tiles/tile_shard.h"

namespace cairn {

// Exact: a tile that is built from the decoded shard is the same to the byte.
std::vector<uint8_t> EncodeShard(const TileShard& shard);

// Throws Error(kMapDamaged) or Error(kBadInput) if the bytes are no shard or have an index, a
// number, a camera or a pose that makes no sense. Untrusted bytes cannot cause reads out of bounds
// or allocations of more than a few times their size.
TileShard DecodeShard(std::span<const uint8_t> bytes);

}  // namespace cairn

#endif  // CAIRN_INGEST_MAPS_SHARD_CODEC_H_
