#include "core/shared_folder.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>

#include "core/error.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

void RequireType(const std::string& path, fs::file_type wanted, const char* name) {
  std::error_code error;
  const fs::file_type type = fs::symlink_status(path, error).type();
  if (type == fs::file_type::symlink) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("{}: is a link; put the {} itself here", path, name));
  }
  if (type != wanted && type != fs::file_type::not_found) {
    throw Error(ErrorCode::kBadInput, fmt::format("{}: is not a {}", path, name));
  }
}

}  // namespace

void RequireUnlinkedFile(const std::string& path) {
  RequireType(path, fs::file_type::regular, "file");
}

void RequireUnlinkedFolder(const std::string& path) {
  RequireType(path, fs::file_type::directory, "folder");
}

}  // namespace cairn
