// The option --index: the search structure of a tile.
#ifndef CAIRN_CLI_INDEX_OPTION_H_
#define CAIRN_CLI_INDEX_OPTION_H_

#include "engine/index/index_options.h"

namespace CLI {
class App;
}

namespace cairn {

// Sets *kind to one of kIndexKindNames; its initial value is the default.
void AddIndexOption(CLI::App* command, IndexKind* kind);

}  // namespace cairn

#endif  // CAIRN_CLI_INDEX_OPTION_H_
