#include "cli/manual/bash_completion.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace cairn {
namespace {

// $1 is the prefix of all names; the tables come before it. A path is the words of a verb: "",
// "keys", "keys new". A key of the tables of values is a path and an option: "localize --index".
constexpr char kFunctions[] = R"bash(
# Sets COMPREPLY to the words that begin with the one under the cursor.
_@_words() {
  mapfile -t COMPREPLY < <(compgen -W "$1" -- "$2")
}

_@_files() {
  compopt -o filenames 2>/dev/null
  mapfile -t COMPREPLY < <(compgen -f -- "$1")
}

_@() {
  local current=${COMP_WORDS[COMP_CWORD]} option="" path="" word i
  COMPREPLY=()
  # bash splits --option=value into three words.
  for ((i = 1; i < COMP_CWORD; ++i)); do
    word=${COMP_WORDS[i]}
    if [[ "${word}" == "=" ]]; then
      continue
    elif [[ -n "${option}" ]]; then
      option=""  # It was a value.
    elif [[ "${word}" == -* ]]; then
      [[ -z "${_@_values["${path} ${word}"]+x}${_@_values[" ${word}"]+x}" ]] || option=${word}
    elif [[ " ${_@_verbs["${path}."]} " == *" ${word} "* ]]; then
      path="${path:+${path} }${word}"
    fi
  done
  [[ "${current}" != "=" ]] || current=""
  if [[ -n "${option}" ]]; then
    local key="${path} ${option}"
    [[ -n "${_@_values["${key}"]+x}" ]] || key=" ${option}"
    if [[ -n "${_@_values["${key}"]}" ]]; then
      _@_words "${_@_values["${key}"]}" "${current}"
    fi
    if [[ "${#COMPREPLY[@]}" -eq 0 && -n "${_@_file_values["${key}"]+x}" ]]; then
      _@_files "${current}"
    fi
  elif [[ "${path}" == help ]]; then
    _@_words "${_@_verbs["."]}" "${current}"
  elif [[ "${current}" == -* ]]; then
    _@_words "${_@_options["${path}."]} ${_@_options["."]}" "${current}"
  elif [[ -n "${_@_verbs["${path}."]}" ]]; then
    _@_words "${_@_verbs["${path}."]}" "${current}"
  elif [[ -n "${_@_positionals["${path}."]}" ]]; then
    _@_words "${_@_positionals["${path}."]}" "${current}"
  elif [[ -n "${path}" ]]; then
    _@_files "${current}"
  fi
}
)bash";

struct Tables {
  std::string verbs, options, values, file_values, positionals;
};

std::vector<std::string> NamesOf(const std::vector<CommandTable>& commands) {
  std::vector<std::string> names;
  for (const CommandTable& command : commands) {
    names.push_back(command.name);
  }
  return names;
}

void Append(const CommandTable& command, const std::string& path, Tables* tables) {
  std::vector<std::string> options;
  for (const ArgumentRow& row : command.arguments) {
    if (row.is_positional) {
      if (!row.words.empty()) {
        tables->positionals += fmt::format("  [\"{}.\"]=\"{}\"\n", path, fmt::join(row.words, " "));
      }
      continue;
    }
    for (const std::string& name : row.names) {
      options.push_back(name);
      if (row.value.empty()) {
        continue;
      }
      tables->values +=
          fmt::format("  [\"{} {}\"]=\"{}\"\n", path, name, fmt::join(row.words, " "));
      if (row.takes_file) {
        tables->file_values += fmt::format("  [\"{} {}\"]=1\n", path, name);
      }
    }
  }
  tables->options += fmt::format("  [\"{}.\"]=\"{}\"\n", path, fmt::join(options, " "));
  if (!command.commands.empty()) {
    tables->verbs +=
        fmt::format("  [\"{}.\"]=\"{}\"\n", path, fmt::join(NamesOf(command.commands), " "));
  }
  for (const CommandTable& below : command.commands) {
    Append(below, path.empty() ? below.name : path + " " + below.name, tables);
  }
}

void ReplaceAll(const std::string& what, const std::string& by, std::string* text) {
  for (size_t at = text->find(what); at != std::string::npos;
       at = text->find(what, at + by.size())) {
    text->replace(at, what.size(), by);
  }
}

}  // namespace

std::string MakeBashCompletion(const CommandTable& program) {
  std::string prefix = program.name;
  std::replace(prefix.begin(), prefix.end(), '-', '_');
  Tables tables;
  Append(program, "", &tables);
  std::string script =
      fmt::format("# Completion of {} by bash; made from its help.\n", program.name);
  for (const auto& [name, content] :
       {std::pair("verbs", tables.verbs), std::pair("options", tables.options),
        std::pair("values", tables.values), std::pair("file_values", tables.file_values),
        std::pair("positionals", tables.positionals)}) {
    script += fmt::format("declare -gA _{}_{}=(\n{})\n", prefix, name, content);
  }
  std::string functions = kFunctions;
  ReplaceAll("_@", "_" + prefix, &functions);
  return script + functions + fmt::format("\ncomplete -F _{} {}\n", prefix, program.name);
}

}  // namespace cairn
