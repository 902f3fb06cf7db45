// Memory kept for the moment when there is none left.
#ifndef CAIRN_CORE_MEMORY_RESERVE_H_
#define CAIRN_CORE_MEMORY_RESERVE_H_

#include <cstddef>

namespace cairn {

// Sets `num_bytes` of address space aside; nothing of it is touched. When operator new fails, the
// reserve is given back and the allocation tried again: a small one then succeeds, a large one
// throws std::bad_alloc and leaves the reserve to what unwinds and reports the failure. That
// matters where failing is no option, as in destructors that allocate (nlohmann::json's do). Once a
// process.
void SetUpMemoryReserve(size_t num_bytes);

// Sets the reserve aside again if it was given back and memory allows. Does nothing in a process
// without one. Safe to call from any thread; never throws.
void RefillMemoryReserve() noexcept;

}  // namespace cairn

#endif  // CAIRN_CORE_MEMORY_RESERVE_H_
