// The folder for files that are needed only while a verb runs.
#ifndef CAIRN_CLI_SCRATCH_DIR_H_
#define CAIRN_CLI_SCRATCH_DIR_H_

#include <string>

namespace cairn {

// The folder that the environment variable TMPDIR names, else /tmp. Throws Error(kIo) if there is
// no such folder.
std::string ScratchDir();

}  // namespace cairn

#endif  // CAIRN_CLI_SCRATCH_DIR_H_
