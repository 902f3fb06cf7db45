#include "cli/whole_file.h"

#include <filesystem>
#include <fstream>
#include <system_error>

#include "core/error.h"

namespace cairn {

void WriteWholeFile(const std::string& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  if (!file.flush()) {
    throw Error(ErrorCode::kIo, path + ": cannot write");
  }
}

void MakeFolders(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error) {
    throw Error(ErrorCode::kIo, path + ": " + error.message());
  }
}

}  // namespace cairn
