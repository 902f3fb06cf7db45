// Checks of files in folders that several people or programs may write to.
#ifndef CAIRN_CORE_SHARED_FOLDER_H_
#define CAIRN_CORE_SHARED_FOLDER_H_

#include <string>

namespace cairn {

// In such a folder, somebody else may put a link where Cairn expects its own file. Reading,
// overwriting or removing what the link names would then happen with the rights of Cairn's user.
// Both functions throw Error(kBadInput), which names the path, if the path exists and is a link or
// of another kind.
void RequireUnlinkedFile(const std::string& path);
void RequireUnlinkedFolder(const std::string& path);

}  // namespace cairn

#endif  // CAIRN_CORE_SHARED_FOLDER_H_
