// Reads a model file from front to back with little memory. Private to ingest/colmap.
#ifndef CAIRN_INGEST_COLMAP_MODEL_BYTES_H_
#define CAIRN_INGEST_COLMAP_MODEL_BYTES_H_

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

namespace cairn {

// The keypoints of a larger file would fill hundreds of gigabytes of memory with descriptors.
inline constexpr uint64_t kMaxModelFileBytes = uint64_t{16} << 30;

// A window that moves over a regular file. Its memory depends on how far the caller looks ahead,
// not on the size of the file, which says nothing about a sparse file.
class ModelBytes {
 public:
  // Throws Error(kNotFound) if there is no such file, and Error(kBadInput) if it is larger than
  // kMaxModelFileBytes.
  explicit ModelBytes(const std::string& path);

  uint64_t size() const { return size_; }
  uint64_t position() const { return position_; }
  uint64_t remaining() const { return size_ - position_; }

  // Returns at least the next `num_bytes` bytes, or fewer at the end of the file. They are valid
  // until the next call. Throws Error(kIo).
  std::string_view Peek(size_t num_bytes);
  // Moves on. At most as many bytes as the last Peek returned.
  void Skip(size_t num_bytes);

 private:
  std::string path_;
  uint64_t size_ = 0;
  std::ifstream file_;
  std::vector<char> buffer_;
  size_t begin_ = 0;  // The unread bytes of the buffer.
  size_t end_ = 0;
  uint64_t position_ = 0;
};

}  // namespace cairn

#endif  // CAIRN_INGEST_COLMAP_MODEL_BYTES_H_
