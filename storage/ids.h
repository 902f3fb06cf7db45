// Identities of the things a map holds. Strong types: one cannot be passed for another.
#ifndef CAIRN_STORAGE_IDS_H_
#define CAIRN_STORAGE_IDS_H_

#include <cstdint>
#include <type_traits>

namespace cairn {

// All start at 1; 0 means "none". Never reused within a map.
enum class SessionId : int64_t {};
enum class KeyframeId : int64_t {};
enum class LandmarkId : uint64_t {};
enum class CodebookId : int64_t {};
enum class PayloadId : int64_t {};   // One encoded tile; changes whenever the tile's bytes change.
enum class MapVersion : int64_t {};  // Rises by one with every published update.

template <typename Id>
constexpr auto Value(Id id) {
  return static_cast<std::underlying_type_t<Id>>(id);
}

}  // namespace cairn

#endif  // CAIRN_STORAGE_IDS_H_
