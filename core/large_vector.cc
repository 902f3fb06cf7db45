#include "core/large_vector.h"

#include <sys/mman.h>

#include <algorithm>
#include <new>

namespace cairn {
namespace {

constexpr std::align_val_t kCacheLine{64};
constexpr size_t kHugePageBytes = size_t{2} << 20;
constexpr std::align_val_t kHugePage{kHugePageBytes};

// Returns the number of huge pages for a block. A partial page counts if the block uses at least
// half of it.
size_t NumHugePages(size_t num_bytes) { return (num_bytes + kHugePageBytes / 2) / kHugePageBytes; }

}  // namespace

void* AllocateLarge(size_t num_bytes) {
  const size_t huge_bytes = NumHugePages(num_bytes) * kHugePageBytes;
  if (huge_bytes == 0) {
    return ::operator new(num_bytes, kCacheLine);
  }
  void* memory = ::operator new(std::max(num_bytes, huge_bytes), kHugePage);
#if defined(MADV_HUGEPAGE)
  // Only advice: if it fails, the memory works without huge pages.
  madvise(memory, huge_bytes, MADV_HUGEPAGE);
#endif
  return memory;
}

void FreeLarge(void* memory, size_t num_bytes) {
  if (NumHugePages(num_bytes) == 0) {
    ::operator delete(memory, kCacheLine);
  } else {
    ::operator delete(memory, kHugePage);
  }
}

}  // namespace cairn
