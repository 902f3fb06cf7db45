// How much memory this process can take.
#ifndef CAIRN_CORE_AVAILABLE_MEMORY_H_
#define CAIRN_CORE_AVAILABLE_MEMORY_H_

#include <cstdint>
#include <optional>
#include <string>

namespace cairn {

// Returns what the machine has free, as Linux estimates it, and swap, or the limit of the process's
// control groups (containers, systemd), if that is less. Returns nothing if the system does not
// tell. `root` is where /proc and /sys are.
std::optional<uint64_t> AvailableMemoryBytes(const std::string& root = "/");

}  // namespace cairn

#endif  // CAIRN_CORE_AVAILABLE_MEMORY_H_
