// Writes files that verbs make at once.
#ifndef CAIRN_CLI_WHOLE_FILE_H_
#define CAIRN_CLI_WHOLE_FILE_H_

#include <string>

namespace cairn {

// Creates or overwrites the file. Throws Error(kIo), which names it.
void WriteWholeFile(const std::string& path, const std::string& text);

// Creates the folder and those above it that are missing. Throws Error(kIo), which names it.
void MakeFolders(const std::string& path);

}  // namespace cairn

#endif  // CAIRN_CLI_WHOLE_FILE_H_
