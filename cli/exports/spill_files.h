// Sorts more records than memory holds by a number, with scratch files.
#ifndef CAIRN_CLI_EXPORTS_SPILL_FILES_H_
#define CAIRN_CLI_EXPORTS_SPILL_FILES_H_

#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

#include "core/scratch_file.h"

namespace cairn {

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
    file_.Read(0, {reinterpret_cast<uint8_t*>(records.data()), file_.size()});
    return records;
  }

 private:
  void Flush() {
    file_.Append(
        {reinterpret_cast<const uint8_t*>(buffer_.data()), buffer_.size() * sizeof(Record)});
    buffer_.clear();
  }

  ScratchFile file_;
  std::vector<Record> buffer_;
};

}  // namespace cairn

#endif  // CAIRN_CLI_EXPORTS_SPILL_FILES_H_
