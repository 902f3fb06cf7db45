// Encodes and decodes the results of a plan. The format is docs/formats/plan_v1.md.
#ifndef CAIRN_INGEST_MAPS_BUILT_TILE_CODEC_H_
#define CAIRN_INGEST_MAPS_BUILT_TILE_CODEC_H_

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "ingest/session_tile_builder.h"

namespace cairn {

// `plan_digest`: the 32 hexadecimal digits that name the plan. Session and tile of the keyframes
// are not encoded.
std::vector<uint8_t> EncodeBuiltTile(const BuiltTile& built, const std::string& plan_digest);

// Throws Error(kMapDamaged) or Error(kBadInput) unless the bytes are the result of this plan for
// this tile, as it was written. Untrusted bytes cannot cause reads out of bounds or allocations of
// more than a few times their size. The keyframes get the session.
BuiltTile DecodeBuiltTile(std::span<const uint8_t> bytes, const std::string& plan_digest,
                          TileId tile_id, SessionId session_id);

}  // namespace cairn

#endif  // CAIRN_INGEST_MAPS_BUILT_TILE_CODEC_H_
