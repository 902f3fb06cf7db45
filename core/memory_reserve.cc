#include "core/memory_reserve.h"

#include <atomic>
#include <cstdlib>
#include <new>

namespace cairn {
namespace {

std::atomic<size_t> reserve_bytes{0};  // 0 if the process has no reserve.
std::atomic<void*> reserve{nullptr};

// The handler of operator new, which calls it repeatedly until the allocation succeeds or this
// function throws.
void GiveReserveBack() {
  void* kept = reserve.exchange(nullptr);
  if (kept == nullptr) {
    throw std::bad_alloc();
  }
  std::free(kept);
}

}  // namespace

void SetUpMemoryReserve(size_t num_bytes) {
  reserve_bytes = num_bytes;
  RefillMemoryReserve();
  std::set_new_handler(GiveReserveBack);
}

void RefillMemoryReserve() noexcept {
  if (reserve_bytes == 0 || reserve != nullptr) {
    return;
  }
  void* kept = std::malloc(reserve_bytes);
  void* expected = nullptr;
  if (!reserve.compare_exchange_strong(expected, kept)) {
    std::free(kept);  // Another thread refilled the reserve first.
  }
}

}  // namespace cairn
