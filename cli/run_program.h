// Runs a binary that consists of verbs: parses the command line, runs one verb, and turns failures
// into messages and exit codes.
#ifndef CAIRN_CLI_RUN_PROGRAM_H_
#define CAIRN_CLI_RUN_PROGRAM_H_

#include "cli/shell.h"

namespace cairn {

struct Program {
  const char* name;         // "cairn".
  const char* description;  // One sentence; begins the help text.
  void (*add_verbs)(CLI::App* app, Shell* shell);
};

// Returns the exit code of main().
int RunProgram(const Program& program, int argc, char** argv);

}  // namespace cairn

#endif  // CAIRN_CLI_RUN_PROGRAM_H_
