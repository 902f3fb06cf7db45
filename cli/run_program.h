// Runs a binary that consists of verbs: parses the command line, runs one verb, and turns failures
// into messages and exit codes.
#ifndef CAIRN_CLI_RUN_PROGRAM_H_
#define CAIRN_CLI_RUN_PROGRAM_H_

#include <string>

#include "cli/build_info.h"
#include "cli/shell.h"

namespace cairn {

// What --version tells; cli/build_info.h.
struct ProgramBuild {
  std::string version, commit, date, compiler, libraries;
};

// Defined here and not in a library: only programs link the facts of the build.
inline ProgramBuild ThisBuild() {
  return {BuildVersion(), BuildCommit(), BuildDate(), BuildCompiler(), BuildLibraries()};
}

struct Program {
  const char* name;         // "cairn".
  const char* description;  // One sentence; begins the help text.
  void (*add_verbs)(CLI::App* app, Shell* shell);
  ProgramBuild build;
};

// Returns the exit code of main().
int RunProgram(const Program& program, int argc, char** argv);

}  // namespace cairn

#endif  // CAIRN_CLI_RUN_PROGRAM_H_
