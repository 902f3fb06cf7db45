// Whole files as bytes.
#ifndef CAIRN_INGEST_READERS_FILE_BYTES_H_
#define CAIRN_INGEST_READERS_FILE_BYTES_H_

#include <cstdint>
#include <string>
#include <vector>

namespace cairn {

// Throws Error(kNotFound) if there is no regular file at `path`, Error(kBadInput) if it has more
// than `max_bytes`, Error(kIo) if reading fails.
std::vector<uint8_t> ReadFileBytes(const std::string& path, uint64_t max_bytes);

}  // namespace cairn

#endif  // CAIRN_INGEST_READERS_FILE_BYTES_H_
