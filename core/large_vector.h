// Vectors for arrays of megabytes that are written right after they were made.
#ifndef CAIRN_CORE_LARGE_VECTOR_H_
#define CAIRN_CORE_LARGE_VECTOR_H_

#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

namespace cairn {

// Memory that starts with a cache line. Large blocks are in huge pages if the system has some to
// give: memory that is touched for the first time costs a page fault, which takes longer than to
// fill the page, and a huge page is one instead of 512. At most half a huge page is left unused.
void* AllocateLarge(size_t num_bytes);
void FreeLarge(void* memory, size_t num_bytes);

// Leaves numbers that are given no value as they are in memory.
template <typename T>
struct LargeAllocator {
  using value_type = T;

  LargeAllocator() = default;
  template <typename U>
  LargeAllocator(const LargeAllocator<U>&) {}  // NOLINT: required of an allocator.

  T* allocate(size_t count) { return static_cast<T*>(AllocateLarge(count * sizeof(T))); }
  void deallocate(T* memory, size_t count) { FreeLarge(memory, count * sizeof(T)); }
  template <typename U>
  void construct(U* place) {
    ::new (static_cast<void*>(place)) U;
  }
  template <typename U, typename... Arguments>
  void construct(U* place, Arguments&&... arguments) {
    std::construct_at(place, std::forward<Arguments>(arguments)...);
  }
  bool operator==(const LargeAllocator&) const { return true; }
};

// A std::vector whose constructor and resize leave numbers without a value: every one must be
// written before it is read.
template <typename T>
using LargeVector = std::vector<T, LargeAllocator<T>>;

}  // namespace cairn

#endif  // CAIRN_CORE_LARGE_VECTOR_H_
