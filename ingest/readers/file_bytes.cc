#include "ingest/readers/file_bytes.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <system_error>

#include "core/error.h"

namespace cairn {

std::vector<uint8_t> ReadFileBytes(const std::string& path, uint64_t max_bytes) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    throw Error(ErrorCode::kNotFound, fmt::format("{}: no such file", path));
  }
  const uint64_t num_bytes = std::filesystem::file_size(path, error);
  if (error) {
    throw Error(ErrorCode::kIo, fmt::format("{}: {}", path, error.message()));
  }
  if (num_bytes > max_bytes) {
    throw Error(ErrorCode::kBadInput, fmt::format("{}: the file has {} bytes; at most {} are read",
                                                  path, num_bytes, max_bytes));
  }
  std::vector<uint8_t> bytes(num_bytes);
  std::ifstream file(path, std::ios::binary);
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(num_bytes));
  if (!file) {
    throw Error(ErrorCode::kIo, fmt::format("{}: cannot be read", path));
  }
  return bytes;
}

}  // namespace cairn
