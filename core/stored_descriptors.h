// The descriptors of an image in bytes, in memory or on disk.
#ifndef CAIRN_CORE_STORED_DESCRIPTORS_H_
#define CAIRN_CORE_STORED_DESCRIPTORS_H_

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <utility>

namespace cairn {

// num_features x descriptor_dim, row-major.
using ByteDescriptorMatrix =
    Eigen::Matrix<uint8_t, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using ByteDescriptor = Eigen::Matrix<uint8_t, 1, Eigen::Dynamic>;

class DescriptorFile;

// Copies share the bytes, which never change. Those on disk (DescriptorFile) are read when they are
// asked for, and then Load and Row throw as ScratchFile does. Safe to use from several threads.
class StoredDescriptors {
 public:
  StoredDescriptors() : StoredDescriptors(ByteDescriptorMatrix()) {}
  StoredDescriptors(ByteDescriptorMatrix bytes)
      : rows_(bytes.rows()),
        cols_(bytes.cols()),
        in_memory_(std::make_shared<const ByteDescriptorMatrix>(std::move(bytes))) {}

  Eigen::Index rows() const { return rows_; }
  Eigen::Index cols() const { return cols_; }

  std::shared_ptr<const ByteDescriptorMatrix> Load() const;  // Never null.
  ByteDescriptor Row(Eigen::Index row) const;                // Reads no other row.

 private:
  friend class DescriptorFile;
  StoredDescriptors(std::shared_ptr<const DescriptorFile> file, uint64_t position,
                    Eigen::Index rows, Eigen::Index cols)
      : rows_(rows), cols_(cols), file_(std::move(file)), position_(position) {}

  Eigen::Index rows_ = 0;
  Eigen::Index cols_ = 0;
  std::shared_ptr<const ByteDescriptorMatrix> in_memory_;  // Null: in the file.
  std::shared_ptr<const DescriptorFile> file_;
  uint64_t position_ = 0;  // In the file.
};

}  // namespace cairn

#endif  // CAIRN_CORE_STORED_DESCRIPTORS_H_
