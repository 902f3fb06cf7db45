#include "http/keys/key_rights.h"

#include <array>
#include <utility>

namespace cairn {
namespace {

constexpr std::array<std::pair<const char*, KeyRight>, 3> kRightNames = {
    {{"localize", KeyRight::kLocalize}, {"look", KeyRight::kLook}, {"copy", KeyRight::kCopy}}};

}  // namespace

std::optional<KeyRight> KeyRightFromName(std::string_view name) {
  for (const auto& [right_name, right] : kRightNames) {
    if (name == right_name) {
      return right;
    }
  }
  return std::nullopt;
}

std::string NamesOf(KeyRights rights, std::string_view separator) {
  std::string names;
  for (const auto& [name, right] : kRightNames) {
    if (rights.Meets(right)) {
      names += names.empty() ? "" : separator;
      names += name;
    }
  }
  return names;
}

}  // namespace cairn
