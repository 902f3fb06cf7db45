#include "cli/options/option_list.h"

#include <utility>

#include "core/check.h"

namespace cairn {

const std::string& NamedChoice::Get() const {
  size_t idx = 0;
  while (idx < names_.size() && !is_(idx)) {
    ++idx;
  }
  CAIRN_CHECK(idx < names_.size(), "the value of an option that is written has a name");
  return names_[idx];
}

bool NamedChoice::Set(std::string_view name) {
  for (size_t idx = 0; idx < names_.size(); ++idx) {
    if (names_[idx] == name) {
      set_(idx);
      return true;
    }
  }
  return false;
}

std::string OptionList::FullName(std::string_view name) const {
  return section_.empty() ? std::string(name) : section_ + "." + std::string(name);
}

void OptionList::AddSection(std::string_view name, std::string meaning,
                            const std::function<void()>& describe) {
  const std::string outer = std::exchange(section_, FullName(name));
  sections_.push_back({section_, std::move(meaning)});
  describe();
  section_ = outer;
}

}  // namespace cairn
