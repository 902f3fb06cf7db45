// --index: what a tile is searched with.
#ifndef CAIRN_CLI_INDEX_OPTION_H_
#define CAIRN_CLI_INDEX_OPTION_H_

#include "engine/index/index_options.h"

namespace CLI {
class App;
}

namespace cairn {

// Sets *kind, whose value is the default. Exhaustive search is no choice: it is for tests.
void AddIndexOption(CLI::App* command, IndexKind* kind);

}  // namespace cairn

#endif  // CAIRN_CLI_INDEX_OPTION_H_
