#include "cli/options/write_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <type_traits>
#include <variant>

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;

constexpr char kIntroduction[] =
    "# Options\n"
    "\n"
    "`cairn options --markdown` writes this page, and a test compares the two.\n"
    "\n"
    "`--options FILE.json` of `cairn serve`, `localize`, `eval`, `ingest`, `plan`, `merge` and\n"
    "`cairn-lab bench` sets what the tables list. `cairn options` prints a file with all of them\n"
    "at their defaults; a file needs only those that differ:\n"
    "\n"
    "```json\n"
    "{\"voting\": {\"max_candidates\": 12}, \"ingest\": {\"selection\": {\"kind\": "
    "\"coverage\"}}}\n"
    "```\n"
    "\n"
    "One file serves all verbs: each uses the sections that it needs and checks the others. A "
    "flag\n"
    "on the command line wins over the file. `\"infinity\"` is a number.\n";

Json ValueAsJson(const OptionValue& value) {
  if (const auto* choice = std::get_if<NamedChoice>(&value)) {
    return choice->Get();
  }
  if (double* const* number = std::get_if<double*>(&value)) {
    return std::isinf(**number) ? Json("infinity") : Json(**number);
  }
  return std::visit(
      [](const auto& integer) {
        if constexpr (std::is_pointer_v<std::remove_cvref_t<decltype(integer)>>) {
          return Json(*integer);
        } else {
          return Json();
        }
      },
      value);
}

// What the column of meanings says.
std::string MeaningOf(const Option& option) {
  const auto* choice = std::get_if<NamedChoice>(&option.value);
  return choice == nullptr
             ? option.meaning
             : fmt::format("{} (`{}`)", option.meaning, fmt::join(choice->names(), "`, `"));
}

std::string TableOf(const OptionSection& section, const OptionList& list) {
  std::string table;
  for (const Option& option : list.options()) {
    if (option.section != section.name) {
      continue;
    }
    table += fmt::format("| `{}` | `{}` | {} |\n", option.name, ValueAsJson(option.value).dump(),
                         MeaningOf(option));
  }
  return table.empty() ? "" : "\n| option | default | meaning |\n|---|---|---|\n" + table;
}

}  // namespace

std::string OptionsAsJson(const CairnOptions& options) {
  CairnOptions copy = options;
  const OptionList list = Describe(&copy);
  Json json = Json::object();
  for (const Option& option : list.options()) {
    std::string pointer = "/" + option.name;
    std::replace(pointer.begin(), pointer.end(), '.', '/');
    json[Json::json_pointer(pointer)] = ValueAsJson(option.value);
  }
  return json.dump(2) + "\n";
}

std::string OptionsAsMarkdown(const CairnOptions& options) {
  CairnOptions copy = options;
  const OptionList list = Describe(&copy);
  std::string page = kIntroduction;
  for (const OptionSection& section : list.sections()) {
    const std::string title = section.name.empty() ? "Top level" : "`" + section.name + "`";
    page += fmt::format("\n## {}\n\n{}.\n{}", title, section.meaning, TableOf(section, list));
  }
  return page;
}

}  // namespace cairn
