// The files of a plan: the manifest, shards and results. What decodes must have one encoding.
#include <cstring>
#include <string>

#include "core/error.h"
#include "fuzz/fuzz_target.h"
#include "fuzz/seal.h"
#include "ingest/maps/built_tile_codec.h"
#include "ingest/maps/plan_json.h"
#include "ingest/maps/shard_codec.h"

namespace cairn {
namespace {

void DecodePlanManifest(const uint8_t* data, size_t size) {
  const std::string json = ManifestAsJson(ManifestFromJson(cairn::testing::AsText(data, size)));
  CAIRN_CHECK(ManifestAsJson(ManifestFromJson(json)) == json,
              "a manifest changes when it is written and read again");
}

void DecodePlanShard(const uint8_t* data, size_t size) {
  const std::vector<uint8_t> bytes = EncodeShard(DecodeShard({data, size}));
  CAIRN_CHECK(EncodeShard(DecodeShard(bytes)) == bytes,
              "a shard changes when it is encoded and decoded again");
}

// The result is taken as one of the plan and of the tile that it names.
void DecodePlanResult(const uint8_t* data, size_t size) {
  constexpr size_t kChecksumOffset = 8, kDigestOffset = 16, kTileOffset = 48;
  const std::vector<uint8_t> bytes = testing::Sealed(data, size, kChecksumOffset);
  if (bytes.size() < kTileOffset + sizeof(uint64_t)) {
    return;
  }
  const std::string digest(bytes.begin() + kDigestOffset, bytes.begin() + kTileOffset);
  uint64_t tile_id = 0;
  std::memcpy(&tile_id, bytes.data() + kTileOffset, sizeof(tile_id));
  const BuiltTile built = DecodeBuiltTile(bytes, digest, TileId::FromValue(tile_id), SessionId(1));
  CAIRN_CHECK(EncodeBuiltTile(built, digest) == bytes, "a result has two encodings");
}

}  // namespace
}  // namespace cairn

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const auto decode = size > 1 && data[0] == 'C' && data[1] == 'S'   ? cairn::DecodePlanShard
                      : size > 1 && data[0] == 'C' && data[1] == 'R' ? cairn::DecodePlanResult
                                                                     : cairn::DecodePlanManifest;
  try {
    decode(data, size);
  } catch (const cairn::Error& error) {
    CAIRN_CHECK(error.code() == cairn::ErrorCode::kBadInput ||
                    error.code() == cairn::ErrorCode::kMapDamaged ||
                    error.code() == cairn::ErrorCode::kInvalidArgument,
                error.what());
  }
  return 0;
}
