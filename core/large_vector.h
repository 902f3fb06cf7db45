// Vectors for arrays of megabytes that are written immediately after allocation.
#ifndef CAIRN_CORE_LARGE_VECTOR_H_
#define CAIRN_CORE_LARGE_VECTOR_H_

#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

namespace cairn {

// Allocates memory that starts at a cache line. Large blocks use huge pages if the system has any.
// The first access to a page causes a page fault, which takes longer than filling the page; a huge
// page causes one fault instead of 512. At most half a huge page stays unused.
void* AllocateLarge(size_t num_bytes);
void FreeLarge(void* memory, size_t num_bytes);

// Does not initialize numbers that are constructed without a value.
template <typename T>
struct LargeAllocator {
  using value_type = T;

  LargeAllocator() = default;
  template <typename U>
  LargeAllocator(const LargeAllocator<U>&) {}  // NOLINT: allocators need this conversion.

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

// A std::vector whose constructor and resize leave numbers uninitialized. Write every element
// before you read it.
template <typename T>
using LargeVector = std::vector<T, LargeAllocator<T>>;

}  // namespace cairn

#endif  // CAIRN_CORE_LARGE_VECTOR_H_
