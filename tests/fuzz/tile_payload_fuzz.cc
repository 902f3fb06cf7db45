// Tile payloads. A decoded tile must be consistent and equal the decoding of its own encoding. The
// parts of a payload that is ready for search must be those of the decoded tile.
#include "core/error.h"
#include "fuzz/fuzz_target.h"
#include "fuzz/seal.h"
#include "storage/tile/tile_codec.h"
#include "storage/tile/tile_payload.h"
#include "support/tile_builder.h"

namespace cairn {
namespace {

constexpr size_t kTileChecksumOffset = 64;
constexpr TileDecodeLimits kTileLimits = {.max_landmarks = 1 << 16,
                                          .max_descriptors = 1 << 16,
                                          .max_keyframes = 1 << 12,
                                          .max_decoded_bytes = 1 << 24};

// Throws Error(kMapDamaged).
void DecodeWhole(const std::vector<uint8_t>& blob) {
  TileLists lists;
  const Tile tile = DecodeTile(blob, kTileLimits, &lists);
  TileLists again;
  CAIRN_CHECK(testing::SameTile(DecodeTile(EncodeTile(tile, lists), kTileLimits, &again), tile),
              "a decoded tile changes when it is encoded and decoded again");
  CAIRN_CHECK(again == lists, "lists change when they are encoded and decoded again");
}

// Throws Error(kMapDamaged).
void DecodeParts(const std::vector<uint8_t>& blob) {
  const TilePayload payload(LargeVector<uint8_t>(blob.begin(), blob.end()), kTileLimits);
  const TileLists lists = payload.Lists();
  CAIRN_CHECK(lists.members.size() == payload.num_descriptors(), "lists miss descriptors");
  payload.CodesInTileOrder(lists.members);
  payload.Landmarks();
  payload.Covisibility();
}

template <typename Decode>
bool Decodes(const Decode& decode, const std::vector<uint8_t>& blob) {
  try {
    decode(blob);
    return true;
  } catch (const Error& error) {
    CAIRN_CHECK(error.code() == ErrorCode::kMapDamaged, error.what());
    return false;
  }
}

}  // namespace
}  // namespace cairn

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::vector<uint8_t> blob = cairn::testing::Sealed(data, size, cairn::kTileChecksumOffset);
  const bool whole = cairn::Decodes(cairn::DecodeWhole, blob);
  if (cairn::TilePayload::IsSearchReady(blob)) {
    const bool parts = cairn::Decodes(cairn::DecodeParts, blob);
    CAIRN_CHECK(parts || !whole, "a tile decodes as a whole and not in parts");
  }
  return 0;
}
