// A reserve of memory for the moment when allocation fails.
#ifndef CAIRN_CORE_MEMORY_RESERVE_H_
#define CAIRN_CORE_MEMORY_RESERVE_H_

#include <cstddef>

namespace cairn {

// Reserves `num_bytes` of address space without touching it. When operator new fails, the reserve
// is released and the allocation is tried again. A small allocation then succeeds; a large one
// throws std::bad_alloc and leaves the released memory for unwinding and reporting. The reserve
// matters where failure is not an option, as in destructors that allocate (nlohmann::json's do).
// Call once per process.
void SetUpMemoryReserve(size_t num_bytes);

// Sets the reserve aside again if it was released and memory allows. Does nothing in a process
// without a reserve. Safe to call from any thread; never throws.
void RefillMemoryReserve() noexcept;

}  // namespace cairn

#endif  // CAIRN_CORE_MEMORY_RESERVE_H_
