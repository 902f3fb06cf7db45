// How much memory this process can take.
#ifndef CAIRN_CORE_AVAILABLE_MEMORY_H_
#define CAIRN_CORE_AVAILABLE_MEMORY_H_

#include <cstdint>
#include <optional>
#include <string>

namespace cairn {

// Returns the bytes of memory and swap that the machine has free, as Linux estimates them, or the
// limit of the process's control groups (containers, systemd) if that is less. What the groups use
// already is not taken off. Returns nothing if the system does not tell. `root` holds proc and sys.
std::optional<uint64_t> AvailableMemoryBytes(const std::string& root = "/");

}  // namespace cairn

#endif  // CAIRN_CORE_AVAILABLE_MEMORY_H_
