#include "cli/scratch_dir.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>

#include "core/error.h"

namespace cairn {

std::string ScratchDir() {
  std::error_code error;
  std::string path = std::filesystem::temp_directory_path(error).string();
  if (error) {
    throw Error(ErrorCode::kIo,
                fmt::format("there is no folder for scratch files: {}. Name one in the environment "
                            "variable TMPDIR",
                            error.message()));
  }
  return path;
}

}  // namespace cairn
