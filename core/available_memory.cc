#include "core/available_memory.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>

namespace cairn {
namespace {

namespace fs = std::filesystem;

std::optional<uint64_t> FreeBytesOfMachine(const fs::path& root) {
  std::ifstream file(root / "proc/meminfo");
  std::string name, unit;
  std::optional<uint64_t> free_bytes;
  uint64_t kilobytes = 0;
  while (file >> name >> kilobytes) {
    if (name == "MemAvailable:" || name == "SwapFree:") {
      free_bytes = free_bytes.value_or(0) + kilobytes * 1024;
    }
    std::getline(file, unit);
  }
  return free_bytes;
}

// Nothing if there is no such file, or the text in it ("max") is no number.
std::optional<uint64_t> NumberIn(const fs::path& path) {
  std::ifstream file(path);
  std::string text;
  file >> text;
  uint64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size() ? std::optional(number)
                                                                  : std::nullopt;
}

void TakeLess(std::optional<uint64_t> other, std::optional<uint64_t>* least) {
  if (other) {
    *least = least->has_value() ? std::min(**least, *other) : *other;
  }
}

// The least limit of a group and those above it. In a container, the path may be the one outside
// of it, of which the inside has the top alone.
std::optional<uint64_t> LimitOfGroup(const fs::path& top, const fs::path& group,
                                     const char* file_name) {
  std::optional<uint64_t> least = NumberIn(top / file_name);
  fs::path at = top;
  for (const fs::path& part : group.relative_path()) {
    at /= part;
    TakeLess(NumberIn(at / file_name), &least);
  }
  return least;
}

// Each line of the file is "number:controllers:path"; version 2 names no controllers.
std::optional<uint64_t> LimitOfGroups(const fs::path& root) {
  const fs::path top = root / "sys/fs/cgroup";
  std::ifstream file(root / "proc/self/cgroup");
  std::optional<uint64_t> least;
  std::string number, controllers, group;
  while (std::getline(file, number, ':') && std::getline(file, controllers, ':') &&
         std::getline(file, group)) {
    if (controllers.empty()) {
      TakeLess(LimitOfGroup(top, group, "memory.max"), &least);
    } else if (("," + controllers + ",").find(",memory,") != std::string::npos) {
      TakeLess(LimitOfGroup(top / "memory", group, "memory.limit_in_bytes"), &least);
    }
  }
  return least;
}

}  // namespace

std::optional<uint64_t> AvailableMemoryBytes(const std::string& root) {
  std::optional<uint64_t> available = FreeBytesOfMachine(root);
  TakeLess(LimitOfGroups(root), &available);
  return available;
}

}  // namespace cairn
