#include "ingest/colmap/model_bytes.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "core/error.h"

namespace cairn {
namespace {

constexpr size_t kChunkBytes = size_t{1} << 20;

uint64_t SizeOf(const std::string& path) {
  std::error_code error;
  const uint64_t size = std::filesystem::file_size(path, error);
  if (error) {
    throw Error(
        error == std::errc::no_such_file_or_directory ? ErrorCode::kNotFound : ErrorCode::kIo,
        fmt::format("{}: {}", path, error.message()));
  }
  if (size > kMaxModelFileBytes) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("{}: {:.1f} GiB; a model file has at most {} GiB. Divide the model "
                            "into several sessions",
                            path, static_cast<double>(size) / (uint64_t{1} << 30),
                            kMaxModelFileBytes >> 30));
  }
  return size;
}

}  // namespace

ModelBytes::ModelBytes(const std::string& path)
    : path_(path), size_(SizeOf(path)), file_(path, std::ios::binary) {
  if (!file_) {
    throw Error(ErrorCode::kIo, fmt::format("{}: cannot be read; check its permissions", path));
  }
}

std::string_view ModelBytes::Peek(size_t num_bytes) {
  if (end_ - begin_ < num_bytes) {
    std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(begin_),
              buffer_.begin() + static_cast<std::ptrdiff_t>(end_), buffer_.begin());
    end_ -= begin_;
    begin_ = 0;
    // No more than the file has, so that small files need little memory.
    const uint64_t unread = remaining() - std::min<uint64_t>(remaining(), end_);
    const size_t wanted = std::max(num_bytes, kChunkBytes);
    buffer_.resize(
        end_ + static_cast<size_t>(std::min<uint64_t>(wanted - std::min(wanted, end_), unread)));
    file_.read(buffer_.data() + end_, static_cast<std::streamsize>(buffer_.size() - end_));
    if (file_.bad()) {
      throw Error(ErrorCode::kIo, fmt::format("{}: cannot be read", path_));
    }
    end_ += static_cast<size_t>(file_.gcount());
  }
  return {buffer_.data() + begin_, end_ - begin_};
}

void ModelBytes::Skip(size_t num_bytes) {
  begin_ += num_bytes;
  position_ += num_bytes;
}

}  // namespace cairn
