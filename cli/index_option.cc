#include "cli/index_option.h"

#include <CLI/CLI.hpp>

#include "cli/choice_option.h"
#include "cli/options/cairn_options.h"

namespace cairn {

void AddIndexOption(CLI::App* command, IndexKind* kind) {
  AddChoiceOption(command, "--index", NamedChoice(kind, kIndexKindNames),
                  "Search structure of a tile; inverted_lists is the fastest");
}

}  // namespace cairn
