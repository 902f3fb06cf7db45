// Verbs that each program has: help, and a hidden one that writes man pages and completion.
#ifndef CAIRN_CLI_HELP_COMMAND_H_
#define CAIRN_CLI_HELP_COMMAND_H_

#include "cli/run_program.h"
#include "cli/shell.h"

namespace cairn {

// `cairn help VERB` prints what `cairn VERB --help` prints.
void AddHelpCommand(CLI::App* app, Shell* shell);

// `cairn write-manual DIR` writes DIR/man1/*.1 and DIR/completions/cairn. The build runs it.
void AddWriteManualCommand(CLI::App* app, Shell* shell, const ProgramBuild& build);

}  // namespace cairn

#endif  // CAIRN_CLI_HELP_COMMAND_H_
