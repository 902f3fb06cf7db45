#include "core/descriptor_file.h"

#include <span>

namespace cairn {

std::shared_ptr<DescriptorFile> DescriptorFile::Create(const std::string& folder) {
  return std::shared_ptr<DescriptorFile>(new DescriptorFile(folder));
}

StoredDescriptors DescriptorFile::Append(const ByteDescriptorMatrix& bytes) {
  const uint64_t position = file_.Append({bytes.data(), static_cast<size_t>(bytes.size())});
  return {shared_from_this(), position, bytes.rows(), bytes.cols()};
}

ByteDescriptorMatrix DescriptorFile::Read(uint64_t position, Eigen::Index rows,
                                          Eigen::Index cols) const {
  ByteDescriptorMatrix bytes(rows, cols);
  file_.Read(position, {bytes.data(), static_cast<size_t>(bytes.size())});
  return bytes;
}

std::shared_ptr<const ByteDescriptorMatrix> DescriptorFile::Load(uint64_t position,
                                                                 Eigen::Index rows,
                                                                 Eigen::Index cols) const {
  // Descriptors without a row lie where the next ones do.
  const std::string key = std::to_string(position) + " " + std::to_string(rows);
  const std::shared_ptr<const Loaded> loaded = cache_.GetOrLoad(
      key, [&] { return std::make_shared<const Loaded>(Loaded{Read(position, rows, cols)}); });
  return {loaded, &loaded->bytes};
}

}  // namespace cairn
