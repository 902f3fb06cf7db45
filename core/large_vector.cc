#include "core/large_vector.h"

#include <sys/mman.h>

#include <algorithm>
#include <mutex>
#include <new>
#include <vector>

namespace cairn {
namespace {

constexpr std::align_val_t kCacheLine{64};
constexpr size_t kHugePageBytes = size_t{2} << 20;
constexpr std::align_val_t kHugePage{kHugePageBytes};

// The huge pages of a block: as many as are at least half used.
size_t NumHugePages(size_t num_bytes) { return (num_bytes + kHugePageBytes / 2) / kHugePageBytes; }

#if defined(__SANITIZE_ADDRESS__)
constexpr size_t kMaxPooledPages = 0;  // Whoever reads freed memory is to be found.
#else
constexpr size_t kMaxPooledPages = 32;  // 64 MB: a tile of the usual size.
#endif

// Freed blocks that wait for the next request of as many pages. Safe to use from any thread.
class BlockPool {
 public:
  BlockPool() { blocks_.reserve(kMaxPooledPages + 1); }

  // Null if there is none of this size.
  void* Take(size_t num_pages) {
    const std::lock_guard lock(mutex_);
    const auto found =
        std::find_if(blocks_.begin(), blocks_.end(),
                     [num_pages](const Block& block) { return block.num_pages == num_pages; });
    if (found == blocks_.end()) {
      return nullptr;
    }
    void* memory = found->memory;
    blocks_.erase(found);
    num_pages_ -= num_pages;
    return memory;
  }

  // The blocks that have waited longest make room.
  void Put(void* memory, size_t num_pages) {
    const std::lock_guard lock(mutex_);
    blocks_.push_back({memory, num_pages});
    num_pages_ += num_pages;
    while (num_pages_ > kMaxPooledPages) {
      ::operator delete(blocks_.front().memory, kHugePage);
      num_pages_ -= blocks_.front().num_pages;
      blocks_.erase(blocks_.begin());
    }
  }

 private:
  struct Block {
    void* memory;
    size_t num_pages;
  };

  std::mutex mutex_;
  std::vector<Block> blocks_;  // In the order in which they were freed; room for all of them.
  size_t num_pages_ = 0;       // Of all blocks.
};

// Never destroyed, as vectors may be freed until the process ends.
BlockPool& Pool() {
  static BlockPool& pool = *new BlockPool;
  return pool;
}

}  // namespace

void* AllocateLarge(size_t num_bytes) {
  const size_t num_pages = NumHugePages(num_bytes);
  if (num_pages == 0) {
    return ::operator new(num_bytes, kCacheLine);
  }
  if (void* memory = Pool().Take(num_pages)) {
    return memory;
  }
  const size_t huge_bytes = num_pages * kHugePageBytes;
  // Room for any request of as many pages.
  void* memory = ::operator new(huge_bytes + kHugePageBytes / 2, kHugePage);
#if defined(MADV_HUGEPAGE)
  madvise(memory, huge_bytes, MADV_HUGEPAGE);  // Advice; the memory is as good without.
#endif
  return memory;
}

void FreeLarge(void* memory, size_t num_bytes) {
  const size_t num_pages = NumHugePages(num_bytes);
  if (num_pages == 0) {
    ::operator delete(memory, kCacheLine);
  } else {
    Pool().Put(memory, num_pages);
  }
}

}  // namespace cairn
