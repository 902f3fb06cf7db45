// Options by name. A description adds the members of a struct to a list; reading, writing and
// documentation go through the list, so none of them can miss an option.
#ifndef CAIRN_CLI_OPTIONS_OPTION_LIST_H_
#define CAIRN_CLI_OPTIONS_OPTION_LIST_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace cairn {

// The name of an enumerator on the command line and in a file.
template <typename E>
struct EnumName {
  const char* name;
  E value;
};

// An option that is an enumerator, reached by its names.
class NamedChoice {
 public:
  // `value` has to outlive the choice.
  template <typename E, size_t N>
  NamedChoice(E* value, const EnumName<E> (&names)[N]) {
    std::vector<E> values;
    for (const EnumName<E>& name : names) {
      names_.emplace_back(name.name);
      values.push_back(name.value);
    }
    is_ = [value, values](size_t idx) { return *value == values[idx]; };
    set_ = [value, values](size_t idx) { *value = values[idx]; };
  }

  const std::vector<std::string>& names() const { return names_; }
  // The name of the value; a CAIRN_CHECK fails if the value has none.
  const std::string& Get() const;
  // False, with the value unchanged, if there is no such name.
  bool Set(std::string_view name);

 private:
  std::vector<std::string> names_;  // In the order of the description.
  std::function<bool(size_t idx)> is_;
  std::function<void(size_t idx)> set_;
};

// Where the value of an option is.
using OptionValue = std::variant<int*, int64_t*, uint64_t*, double*, NamedChoice>;

struct Option {
  std::string section;  // "matching.index"; empty at the top level.
  std::string name;     // With its section: "matching.index.kind".
  OptionValue value;
  std::string meaning;  // One line of plain text, with the unit.
};

struct OptionSection {
  std::string name;     // As Option::section.
  std::string meaning;  // One line of plain text.
};

// Refers to the structs that were described, which must outlive it.
class OptionList {
 public:
  // `meaning` is about the top level.
  explicit OptionList(std::string meaning) { sections_.push_back({"", std::move(meaning)}); }

  // Adds an option to the section that is being described.
  template <typename T>
  void Add(std::string_view name, T* value, std::string meaning) {
    options_.push_back({section_, FullName(name), OptionValue(value), std::move(meaning)});
  }
  template <typename E, size_t N>
  void Add(std::string_view name, E* value, const EnumName<E> (&names)[N], std::string meaning) {
    options_.push_back({section_, FullName(name), NamedChoice(value, names), std::move(meaning)});
  }

  // Adds a section inside of the one that is being described; `describe` adds its options.
  void AddSection(std::string_view name, std::string meaning,
                  const std::function<void()>& describe);

  // In the order of the description; a section comes before what is in it.
  const std::vector<Option>& options() const { return options_; }
  std::vector<Option>& options() { return options_; }
  const std::vector<OptionSection>& sections() const { return sections_; }

 private:
  std::string FullName(std::string_view name) const;

  std::string section_;
  std::vector<Option> options_;
  std::vector<OptionSection> sections_;
};

}  // namespace cairn

#endif  // CAIRN_CLI_OPTIONS_OPTION_LIST_H_
