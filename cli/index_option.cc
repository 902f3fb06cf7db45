#include "cli/index_option.h"

#include <CLI/CLI.hpp>
#include <map>
#include <string>
#include <vector>

namespace cairn {

void AddIndexOption(CLI::App* command, IndexKind* kind) {
  std::map<std::string, IndexKind> kinds;
  for (const IndexKind choice : {IndexKind::kRandomGrids, IndexKind::kInvertedLists}) {
    kinds.emplace(IndexKindName(choice), choice);
  }
  std::vector<std::string> names;
  for (const auto& [name, choice] : kinds) {
    names.push_back(name);
  }
  command
      ->add_option_function<std::string>(
          "--index", [kinds, kind](const std::string& name) { *kind = kinds.at(name); },
          "Search structure of a tile; inverted_lists is the fastest")
      ->check(CLI::IsMember(names))
      ->type_name("KIND")
      ->default_str(IndexKindName(*kind));
}

}  // namespace cairn
