#include "core/file_bytes.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <system_error>

#include "core/error.h"
#include "core/printable.h"
#include "core/utf16.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

constexpr size_t kChunkBytes = size_t{1} << 20;

[[noreturn]] void ThrowTooLarge(const std::string& path, uint64_t max_bytes) {
  throw Error(ErrorCode::kBadInput,
              fmt::format("{}: the file is larger than the limit of {} bytes", path, max_bytes));
}

// Returns the reported size of a regular file, and 0 for any other file.
uint64_t ExpectedBytes(const std::string& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) {
    throw Error(ErrorCode::kNotFound, fmt::format("{}: no such file", path));
  }
  if (status.type() == fs::file_type::directory) {
    throw Error(ErrorCode::kBadInput, fmt::format("{}: this is a directory, not a file", path));
  }
  if (status.type() != fs::file_type::regular) {
    return 0;
  }
  const uint64_t num_bytes = fs::file_size(path, error);
  if (error) {
    throw Error(ErrorCode::kIo, fmt::format("{}: {}", path, error.message()));
  }
  return num_bytes;
}

}  // namespace

std::vector<uint8_t> ReadFileBytes(const std::string& path, uint64_t max_bytes) {
  const uint64_t expected_bytes = ExpectedBytes(path);
  if (expected_bytes > max_bytes) {
    ThrowTooLarge(path, max_bytes);
  }
  std::ifstream file(path, std::ios::binary);
  std::vector<uint8_t> bytes;
  while (file) {
    const size_t begin = bytes.size();
    // A regular file is read at once, without copies. The extra byte detects the end of the file.
    const bool is_expected = begin == 0 && expected_bytes > 0;
    bytes.resize(begin + (is_expected ? expected_bytes + 1 : kChunkBytes));
    file.read(reinterpret_cast<char*>(bytes.data() + begin),
              static_cast<std::streamsize>(bytes.size() - begin));
    bytes.resize(begin + static_cast<size_t>(file.gcount()));
    if (bytes.size() > max_bytes) {
      ThrowTooLarge(path, max_bytes);
    }
  }
  if (!file.eof()) {
    throw Error(ErrorCode::kIo, fmt::format("{}: cannot be read", path));
  }
  return bytes;
}

std::string ReadTextFile(const std::string& path, uint64_t max_bytes) {
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  const std::vector<uint8_t> bytes = ReadFileBytes(path, max_bytes);
  std::string text(bytes.begin(), bytes.end());
  if (text.starts_with(kByteOrderMark)) {
    text.erase(0, kByteOrderMark.size());
  }
  if (IsUtf16(text)) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("{}: the text is UTF-16; save it as UTF-8", Printable(path)));
  }
  if (text.find('\0') != text.npos) {
    const bool may_be_spreadsheet = text.starts_with("PK\x03\x04") || text.starts_with("\xd0\xcf");
    throw Error(ErrorCode::kBadInput,
                fmt::format("{}: this is not a text file: it has zero bytes{}", Printable(path),
                            may_be_spreadsheet ? "; save a spreadsheet as CSV" : ""));
  }
  return text;
}

void WriteFileBytes(const std::string& path, std::span<const uint8_t> bytes) {
  WriteTextFile(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

void WriteTextFile(const std::string& path, std::string_view text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  if (!file.flush()) {
    throw Error(ErrorCode::kIo, path + ": cannot write");
  }
}

}  // namespace cairn
