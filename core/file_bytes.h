// Whole files as bytes.
#ifndef CAIRN_CORE_FILE_BYTES_H_
#define CAIRN_CORE_FILE_BYTES_H_

#include <cstdint>
#include <string>
#include <vector>

namespace cairn {

// Reads files, pipes and devices to their end. Throws Error(kNotFound) if there is nothing at
// `path`, Error(kBadInput) if it is a directory or has more than `max_bytes`, of which no more is
// read, Error(kIo) if reading fails.
std::vector<uint8_t> ReadFileBytes(const std::string& path, uint64_t max_bytes);

// The same as text, without the byte order mark that some programs write first.
std::string ReadTextFile(const std::string& path, uint64_t max_bytes);

}  // namespace cairn

#endif  // CAIRN_CORE_FILE_BYTES_H_
