// --options: the file that sets what has no flag.
#ifndef CAIRN_CLI_OPTIONS_FILE_H_
#define CAIRN_CLI_OPTIONS_FILE_H_

#include "cli/options/cairn_options.h"

namespace CLI {
class App;
}  // namespace CLI

namespace cairn {

// Call it before adding flags that set members of `options`, which then win over the file, wherever
// they stand on the command line. A file that is wrong is reported while the command line is
// parsed, by an Error as of ReadOptionsFile.
void AddOptionsFile(CLI::App* command, CairnOptions* options);

}  // namespace cairn

#endif  // CAIRN_CLI_OPTIONS_FILE_H_
