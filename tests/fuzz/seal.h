// Corrects checksums, so that a fuzz target reaches the code behind the check. An attacker can
// compute the checksum of a hostile payload, too.
#ifndef CAIRN_TESTS_FUZZ_SEAL_H_
#define CAIRN_TESTS_FUZZ_SEAL_H_

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "storage/tile/checksum.h"

namespace cairn::testing {

// Returns the bytes with the correct checksum at `checksum_offset`, if they are long enough.
inline std::vector<uint8_t> Sealed(const uint8_t* data, size_t size, size_t checksum_offset) {
  std::vector<uint8_t> bytes(data, data + size);
  if (size >= checksum_offset + sizeof(uint64_t)) {
    const uint64_t checksum = ChecksumOf(bytes, checksum_offset);
    std::memcpy(bytes.data() + checksum_offset, &checksum, sizeof(checksum));
  }
  return bytes;
}

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_FUZZ_SEAL_H_
