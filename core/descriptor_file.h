// The descriptors of many images on disk instead of in memory.
#ifndef CAIRN_CORE_DESCRIPTOR_FILE_H_
#define CAIRN_CORE_DESCRIPTOR_FILE_H_

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "core/loading_cache.h"
#include "core/scratch_file.h"
#include "core/stored_descriptors.h"

namespace cairn {

// A scratch file, with a cache of what was read last. It stays as long as descriptors in it do.
// Safe to use from several threads. All functions throw as ScratchFile does.
class DescriptorFile : public std::enable_shared_from_this<DescriptorFile> {
 public:
  // On the disk of `folder`.
  static std::shared_ptr<DescriptorFile> Create(const std::string& folder);

  StoredDescriptors Append(const ByteDescriptorMatrix& bytes);

  // For StoredDescriptors: what was appended at `position`, through the cache and without it.
  std::shared_ptr<const ByteDescriptorMatrix> Load(uint64_t position, Eigen::Index rows,
                                                   Eigen::Index cols) const;
  ByteDescriptorMatrix Read(uint64_t position, Eigen::Index rows, Eigen::Index cols) const;

  // As that of ScratchFile.
  bool is_on_disk() const { return file_.is_on_disk(); }

  // For work that needs memory and no descriptors.
  void EmptyCache() { cache_.Clear(); }
  size_t CachedBytes() const { return cache_.Stats().bytes; }

 private:
  struct Loaded {
    ByteDescriptorMatrix bytes;
    size_t MemoryBytes() const { return static_cast<size_t>(bytes.size()); }
  };
  // The partners of a photo and those of the next are mostly the same: some 100 photos with 4,000
  // keypoints each.
  static constexpr size_t kCacheBytes = size_t{64} << 20;

  explicit DescriptorFile(const std::string& folder) : file_(folder), cache_(kCacheBytes) {}

  ScratchFile file_;
  mutable LoadingCache<Loaded> cache_;
};

}  // namespace cairn

#endif  // CAIRN_CORE_DESCRIPTOR_FILE_H_
