#include "cli/build_info.h"

namespace cairn {

const char* BuildVersion() { return CAIRN_VERSION; }
const char* BuildCompiler() { return CAIRN_COMPILER; }
const char* BuildLibraries() { return CAIRN_LIBRARIES; }

}  // namespace cairn
