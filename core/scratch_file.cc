#include "core/scratch_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/magic.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "core/error.h"
#include "core/printable.h"

namespace cairn {
namespace {

[[noreturn]] void ThrowOf(const std::string& folder, const char* what, const char* reason) {
  throw Error(ErrorCode::kIo,
              fmt::format("{}: a scratch file cannot be {}: {}", Printable(folder), what, reason));
}

// Calls pread or pwrite until all bytes are done.
template <typename Transfer>
void TransferAll(const std::string& folder, const char* what, size_t size, Transfer transfer) {
  for (size_t num_done = 0; num_done < size;) {
    const ssize_t done = transfer(num_done);
    if (done == 0) {
      ThrowOf(folder, what, "it is shorter than it was");
    }
    if (done < 0 && errno != EINTR) {
      ThrowOf(folder, what, std::strerror(errno));
    }
    num_done += done < 0 ? 0 : static_cast<size_t>(done);
  }
}

}  // namespace

ScratchFile::ScratchFile(const std::string& folder) : folder_(folder) {
  std::string name = folder + "/.cairn_scratch_XXXXXX";
  fd_ = mkostemp(name.data(), O_CLOEXEC);
  if (fd_ < 0) {
    ThrowOf(folder_, "made", std::strerror(errno));
  }
  unlink(name.c_str());
}

ScratchFile::~ScratchFile() { close(fd_); }

bool ScratchFile::is_on_disk() const {
  struct statfs info = {};
  return fstatfs(fd_, &info) != 0 || (info.f_type != TMPFS_MAGIC && info.f_type != RAMFS_MAGIC);
}

uint64_t ScratchFile::Append(std::span<const uint8_t> bytes) {
  const uint64_t position = size_.fetch_add(bytes.size());
  TransferAll(folder_, "written", bytes.size(), [&](size_t num_done) {
    return pwrite(fd_, bytes.data() + num_done, bytes.size() - num_done,
                  static_cast<off_t>(position + num_done));
  });
  return position;
}

void ScratchFile::Read(uint64_t position, std::span<uint8_t> bytes) const {
  TransferAll(folder_, "read", bytes.size(), [&](size_t num_done) {
    return pread(fd_, bytes.data() + num_done, bytes.size() - num_done,
                 static_cast<off_t>(position + num_done));
  });
}

}  // namespace cairn
