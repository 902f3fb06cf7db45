// Reads whole files.
#ifndef CAIRN_CORE_FILE_BYTES_H_
#define CAIRN_CORE_FILE_BYTES_H_

#include <cstdint>
#include <string>
#include <vector>

namespace cairn {

// Reads a file, pipe or device to its end. Throws Error(kNotFound) if `path` does not exist,
// Error(kBadInput) if it is a directory or holds more than `max_bytes`, and Error(kIo) if reading
// fails. Never reads much beyond `max_bytes`.
std::vector<uint8_t> ReadFileBytes(const std::string& path, uint64_t max_bytes);

// Reads a file as text, without the byte order mark that some programs write first. Throws what
// ReadFileBytes throws, and Error(kBadInput) for UTF-16.
std::string ReadTextFile(const std::string& path, uint64_t max_bytes);

}  // namespace cairn

#endif  // CAIRN_CORE_FILE_BYTES_H_
