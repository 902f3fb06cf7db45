#include "cli/make_folders.h"

#include <filesystem>
#include <system_error>

#include "core/error.h"

namespace cairn {

void MakeFolders(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error) {
    throw Error(ErrorCode::kIo, path + ": " + error.message());
  }
}

}  // namespace cairn
