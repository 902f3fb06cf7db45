#include "cli/index_option.h"

#include <CLI/CLI.hpp>
#include <map>
#include <string>

namespace cairn {

void AddIndexOption(CLI::App* command, IndexKind* kind) {
  std::map<std::string, IndexKind> kinds;
  for (const IndexKind choice : {IndexKind::kRandomGrids, IndexKind::kInvertedLists,
                                 IndexKind::kInvertedMultiIndex, IndexKind::kKdTree}) {
    kinds.emplace(IndexKindName(choice), choice);
  }
  command->add_option("--index", *kind, "What a tile is searched with; inverted_lists is fastest")
      ->transform(CLI::CheckedTransformer(kinds, CLI::ignore_case).description("KIND"))
      ->default_str(IndexKindName(*kind));
}

}  // namespace cairn
