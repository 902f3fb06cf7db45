// Writes whole files so that nobody sees half of one.
#ifndef CAIRN_CORE_REPLACE_FILE_H_
#define CAIRN_CORE_REPLACE_FILE_H_

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace cairn {

// The end of the names of unfinished files.
inline constexpr const char* kUnfinishedSuffix = ".part";

// Writes the bytes to a new file beside `path`, `path` + "." + a random number + ".part", to disk,
// and renames it to `path`. A process that dies leaves the file under the first name. If somebody
// removes the unfinished file because `path` exists already, that is as good as done. Throws
// Error(kIo).
void ReplaceFile(const std::string& path, std::span<const uint8_t> bytes);

// The same for content that is written piece by piece. Nobody sees it before Commit, and without
// Commit the destructor leaves `path` as it was. Use from one thread. All functions throw
// Error(kIo).
class FileReplacement {
 public:
  explicit FileReplacement(const std::string& path);
  ~FileReplacement();

  void Write(std::string_view bytes);      // Collects small pieces.
  uint64_t size() const { return size_; }  // Bytes written so far.
  // Replaces bytes that were written before, e.g. a count that was not known then.
  void Overwrite(uint64_t position, std::string_view bytes);
  void Commit();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  uint64_t size_ = 0;
};

}  // namespace cairn

#endif  // CAIRN_CORE_REPLACE_FILE_H_
