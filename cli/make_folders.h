// Makes the folders of the files that verbs write.
#ifndef CAIRN_CLI_MAKE_FOLDERS_H_
#define CAIRN_CLI_MAKE_FOLDERS_H_

#include <string>

namespace cairn {

// Creates the folder and those above it that are missing. Throws Error(kIo), which names it.
void MakeFolders(const std::string& path);

}  // namespace cairn

#endif  // CAIRN_CLI_MAKE_FOLDERS_H_
