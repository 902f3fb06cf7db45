// Makes the file in which the descriptors of photos lie while a map is made.
#ifndef CAIRN_CLI_MAKE_DESCRIPTOR_FILE_H_
#define CAIRN_CLI_MAKE_DESCRIPTOR_FILE_H_

#include <memory>

#include "core/descriptor_file.h"

namespace cairn {

// In the folder that the environment variable TMPDIR names, else in /tmp. Throws Error(kIo), which
// says so, if no file can be made there.
std::shared_ptr<DescriptorFile> MakeDescriptorFile();

}  // namespace cairn

#endif  // CAIRN_CLI_MAKE_DESCRIPTOR_FILE_H_
