// What a client may do.
#ifndef CAIRN_HTTP_KEYS_KEY_RIGHTS_H_
#define CAIRN_HTTP_KEYS_KEY_RIGHTS_H_

#include <optional>
#include <string>
#include <string_view>

namespace cairn {

enum class KeyRight : unsigned {
  kLocalize = 1,  // Queries.
  kLook = 2,      // What the map covers, and how the server is: lists of tiles, versions, metrics.
  kCopy = 4,      // The tiles themselves.
};

// A set of rights.
class KeyRights {
 public:
  constexpr KeyRights() = default;
  constexpr KeyRights(KeyRight right) : bits_(static_cast<unsigned>(right)) {}  // NOLINT: a set.

  constexpr KeyRights operator|(KeyRights other) const { return KeyRights(bits_ | other.bits_); }
  constexpr bool empty() const { return bits_ == 0; }
  constexpr bool Meets(KeyRights other) const { return (bits_ & other.bits_) != 0; }
  constexpr bool operator==(const KeyRights&) const = default;

 private:
  constexpr explicit KeyRights(unsigned bits) : bits_(bits) {}
  unsigned bits_ = 0;
};

constexpr KeyRights operator|(KeyRight a, KeyRight b) { return KeyRights(a) | KeyRights(b); }

// "localize", "look" or "copy"; nothing for another name.
std::optional<KeyRight> KeyRightFromName(std::string_view name);

// The names in that order, with `separator` between them.
std::string NamesOf(KeyRights rights, std::string_view separator);

}  // namespace cairn

#endif  // CAIRN_HTTP_KEYS_KEY_RIGHTS_H_
