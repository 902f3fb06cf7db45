// Tells whether something is mounted at a path.
#ifndef CAIRN_STORAGE_MAP_MOUNT_POINT_H_
#define CAIRN_STORAGE_MAP_MOUNT_POINT_H_

#include <string>

namespace cairn {

// Returns true if the path is the root of a mount, for example a file that a container was given
// without its folder. The files that other programs put beside such a file are not visible here.
// Returns false if the path does not exist or the system does not list its mounts.
bool IsMountPoint(const std::string& path);

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_MOUNT_POINT_H_
