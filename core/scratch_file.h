// A file without a name, for more than memory holds.
#ifndef CAIRN_CORE_SCRATCH_FILE_H_
#define CAIRN_CORE_SCRATCH_FILE_H_

#include <atomic>
#include <cstdint>
#include <span>
#include <string>

namespace cairn {

// Nothing is left of the file when the object is gone or the process dies. All functions throw
// Error(kIo), which names the folder, e.g. if its disk is full. Safe to use from several threads.
class ScratchFile {
 public:
  // On the disk of `folder`.
  explicit ScratchFile(const std::string& folder);
  ~ScratchFile();
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;

  // Returns the position of the first byte.
  uint64_t Append(std::span<const uint8_t> bytes);
  // Fills `bytes` with what was appended at `position`.
  void Read(uint64_t position, std::span<uint8_t> bytes) const;

  uint64_t size() const { return size_; }
  // False if the folder is a file system that keeps its files in memory.
  bool is_on_disk() const;

 private:
  std::string folder_;
  int fd_ = -1;
  std::atomic<uint64_t> size_ = 0;
};

}  // namespace cairn

#endif  // CAIRN_CORE_SCRATCH_FILE_H_
