// Ids of the things a map holds. The types are strong: one id cannot be passed for another.
#ifndef CAIRN_STORAGE_IDS_H_
#define CAIRN_STORAGE_IDS_H_

#include <cstdint>
#include <type_traits>

namespace cairn {

// Ids start at 1; 0 means "none". An id is never reused within a map.
enum class SessionId : int64_t {};
enum class KeyframeId : int64_t {};
enum class LandmarkId : uint64_t {};
enum class CodebookId : int64_t {};
// One encoded tile; a tile gets a new id whenever its bytes change.
enum class PayloadId : int64_t {};
enum class MapVersion : int64_t {};  // Rises by one with every published update.

template <typename Id>
constexpr auto Value(Id id) {
  return static_cast<std::underlying_type_t<Id>>(id);
}

}  // namespace cairn

#endif  // CAIRN_STORAGE_IDS_H_
