#include "core/stored_descriptors.h"

#include "core/descriptor_file.h"

namespace cairn {

std::shared_ptr<const ByteDescriptorMatrix> StoredDescriptors::Load() const {
  return in_memory_ ? in_memory_ : file_->Load(position_, rows_, cols_);
}

ByteDescriptor StoredDescriptors::Row(Eigen::Index row) const {
  return in_memory_ ? ByteDescriptor(in_memory_->row(row))
                    : file_->Read(position_ + static_cast<uint64_t>(row * cols_), 1, cols_).row(0);
}

}  // namespace cairn
