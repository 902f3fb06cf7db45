// Writes whole files so that nobody sees half of one.
#ifndef CAIRN_CORE_REPLACE_FILE_H_
#define CAIRN_CORE_REPLACE_FILE_H_

#include <cstdint>
#include <span>
#include <string>

namespace cairn {

// The end of the names of unfinished files.
inline constexpr const char* kUnfinishedSuffix = ".part";

// Writes the bytes to a new file beside `path`, `path` + "." + a random number + ".part", to disk,
// and renames it to `path`. A process that dies leaves the file under the first name. If somebody
// removes the unfinished file because `path` exists already, that is as good as done. Throws
// Error(kIo).
void ReplaceFile(const std::string& path, std::span<const uint8_t> bytes);

}  // namespace cairn

#endif  // CAIRN_CORE_REPLACE_FILE_H_
