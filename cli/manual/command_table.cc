#include "cli/manual/command_table.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <string_view>

namespace cairn {
namespace {

// CLI11's name of the type of an option that has got none.
constexpr std::string_view kText = "TEXT";

bool IsWord(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return std::islower(c) != 0 || std::isdigit(c) != 0 || c == '_' || c == '-';
  });
}

std::vector<std::string_view> SplitAtBars(std::string_view text) {
  std::vector<std::string_view> parts;
  for (size_t bar = text.find('|'); bar != std::string_view::npos; bar = text.find('|')) {
    parts.push_back(text.substr(0, bar));
    text.remove_prefix(bar + 1);
  }
  parts.push_back(text);
  return parts;
}

// Whether a value of this name is a path: "FILE.json", "DIR", "MAP".
bool IsFileName(std::string_view name) {
  const std::string_view stem = name.substr(0, name.find('.'));
  for (const std::string_view known :
       {"FILE", "DIR", "MAP", "PLAN", "PNG", "CSV", "TEXT", "FROM", "TO", "LIST", "A", "B"}) {
    if (stem == known) {
      return true;
    }
  }
  return false;
}

void ReadValue(const CLI::Option& option, ArgumentRow* row) {
  const std::string type = option.get_type_name();
  const std::vector<std::string_view> parts = SplitAtBars(type);
  row->takes_file = IsFileName(row->is_positional ? row->names.front() : type);
  if (parts.size() < 2) {
    return;
  }
  for (const std::string_view part : parts) {
    if (IsWord(part)) {
      row->words.emplace_back(part);
    }
    row->takes_file = row->takes_file || IsFileName(part);
  }
}

ArgumentRow RowOf(const CLI::Option& option) {
  ArgumentRow row;
  row.is_positional = !option.nonpositional();
  if (row.is_positional) {
    row.names.push_back(option.get_name(true));
  } else {
    for (const std::string& name : option.get_snames()) {
      row.names.push_back("-" + name);
    }
    for (const std::string& name : option.get_lnames()) {
      row.names.push_back("--" + name);
    }
  }
  const bool has_value = option.get_type_size() != 0;
  const std::string type = has_value ? option.get_type_name() : "";
  row.value = row.is_positional && type == kText ? "" : type;
  row.default_value = has_value ? option.get_default_str() : "";
  row.meaning = option.get_description();
  row.is_required = option.get_required();
  row.is_repeated = option.get_expected_max() > 1;
  for (const CLI::Option* needed : option.get_needs()) {
    row.needs.push_back(needed->get_name());
  }
  std::sort(row.needs.begin(), row.needs.end());  // CLI11 orders them by address.
  if (has_value) {
    ReadValue(option, &row);
  }
  return row;
}

}  // namespace

CommandTable TableOf(const CLI::App& app) {
  CommandTable table = {app.get_name(), app.get_description(), app.get_footer(), {}, {}};
  for (const CLI::Option* option : app.get_options()) {
    if (!option->get_group().empty()) {  // Those without a group are hidden.
      table.arguments.push_back(RowOf(*option));
    }
  }
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    CommandTable of_command = TableOf(*command);
    if (command->get_name().empty()) {  // A group of options.
      table.arguments.insert(table.arguments.end(), of_command.arguments.begin(),
                             of_command.arguments.end());
    } else if (!command->get_group().empty()) {
      table.commands.push_back(std::move(of_command));
    }
  }
  return table;
}

}  // namespace cairn
