// Sorts more records than memory holds by a number, with unnamed files.
#ifndef CAIRN_CLI_EXPORTS_SPILL_FILES_H_
#define CAIRN_CLI_EXPORTS_SPILL_FILES_H_

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <vector>

#include "core/error.h"

namespace cairn {

// A file that has no name any more, so that nothing is left of it if the process dies.
class UnnamedFile {
 public:
  // On the disk of `folder`. Throws Error(kIo), as all functions do.
  explicit UnnamedFile(const std::string& folder) : folder_(folder) {
    std::string name = folder + "/.cairn_export_XXXXXX";
    fd_ = mkostemp(name.data(), O_CLOEXEC);
    if (fd_ < 0) {
      Throw();
    }
    unlink(name.c_str());
  }
  ~UnnamedFile() { close(fd_); }
  UnnamedFile(const UnnamedFile&) = delete;
  UnnamedFile& operator=(const UnnamedFile&) = delete;

  void Append(const void* bytes, size_t size) {
    const auto* at = static_cast<const char*>(bytes);
    while (size > 0) {
      const ssize_t done = pwrite(fd_, at, size, static_cast<off_t>(size_));
      if (done < 0 && errno != EINTR) {
        Throw();
      }
      const size_t num_written = done < 0 ? 0 : static_cast<size_t>(done);
      at += num_written;
      size -= num_written;
      size_ += num_written;
    }
  }

  uint64_t size() const { return size_; }

  void ReadAll(void* bytes) const {
    auto* at = static_cast<char*>(bytes);
    for (uint64_t position = 0; position < size_;) {
      const ssize_t done =
          pread(fd_, at + position, size_ - position, static_cast<off_t>(position));
      if (done == 0 || (done < 0 && errno != EINTR)) {
        Throw();
      }
      position += done < 0 ? 0 : static_cast<uint64_t>(done);
    }
  }

 private:
  [[noreturn]] void Throw() const {
    throw Error(ErrorCode::kIo, fmt::format("{}: {}", folder_, std::strerror(errno)));
  }

  std::string folder_;
  int fd_ = -1;
  uint64_t size_ = 0;
};

// Records in the order of Add.
template <typename Record>
class SpillFile {
 public:
  explicit SpillFile(const std::string& folder) : file_(folder) {}

  void Add(const Record& record) {
    static_assert(std::is_trivially_copyable_v<Record>);
    constexpr size_t kBufferRecords = 4096;
    buffer_.push_back(record);
    if (buffer_.size() == kBufferRecords) {
      Flush();
    }
  }

  std::vector<Record> TakeAll() {
    Flush();
    std::vector<Record> records(file_.size() / sizeof(Record));
    file_.ReadAll(records.data());
    return records;
  }

 private:
  void Flush() {
    file_.Append(buffer_.data(), buffer_.size() * sizeof(Record));
    buffer_.clear();
  }

  UnnamedFile file_;
  std::vector<Record> buffer_;
};

}  // namespace cairn

#endif  // CAIRN_CLI_EXPORTS_SPILL_FILES_H_
