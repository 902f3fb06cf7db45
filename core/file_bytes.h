// Reads and writes whole files.
#ifndef CAIRN_CORE_FILE_BYTES_H_
#define CAIRN_CORE_FILE_BYTES_H_

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace cairn {

// Reads a file, pipe or device to its end. Throws Error(kNotFound) if `path` does not exist,
// Error(kBadInput) if it is a directory or holds more than `max_bytes`, and Error(kIo) if reading
// fails. Never reads much beyond `max_bytes`.
std::vector<uint8_t> ReadFileBytes(const std::string& path, uint64_t max_bytes);

// Reads a file as text, without the byte order mark that some programs write first. Throws what
// ReadFileBytes throws, and Error(kBadInput) for UTF-16 and for zero bytes, which no text has.
std::string ReadTextFile(const std::string& path, uint64_t max_bytes);

// Creates or overwrites the file, pipe or device. Readers may see a part of it: see ReplaceFile.
// Throws Error(kIo), which names it.
void WriteFileBytes(const std::string& path, std::span<const uint8_t> bytes);
void WriteTextFile(const std::string& path, std::string_view text);

}  // namespace cairn

#endif  // CAIRN_CORE_FILE_BYTES_H_
