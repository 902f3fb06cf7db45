// The checksum of storage's byte formats. Private to storage, ingest and mapping.
#ifndef CAIRN_STORAGE_TILE_CHECKSUM_H_
#define CAIRN_STORAGE_TILE_CHECKSUM_H_

#include <xxhash.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace cairn {

// XXH64 with seed 0 over all bytes except the 8 at `checksum_offset`, which hold the checksum.
inline uint64_t ChecksumOf(std::span<const uint8_t> bytes, size_t checksum_offset) {
  const std::unique_ptr<XXH64_state_t, decltype(&XXH64_freeState)> state(XXH64_createState(),
                                                                         &XXH64_freeState);
  const std::span<const uint8_t> rest = bytes.subspan(checksum_offset + sizeof(uint64_t));
  XXH64_reset(state.get(), 0);
  XXH64_update(state.get(), bytes.data(), checksum_offset);
  XXH64_update(state.get(), rest.data(), rest.size());
  return XXH64_digest(state.get());
}

}  // namespace cairn

#endif  // CAIRN_STORAGE_TILE_CHECKSUM_H_
