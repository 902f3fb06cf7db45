// Completion of command lines by bash.
#ifndef CAIRN_CLI_MANUAL_BASH_COMPLETION_H_
#define CAIRN_CLI_MANUAL_BASH_COMPLETION_H_

#include <string>

#include "cli/manual/command_table.h"

namespace cairn {

// A script for bash 4.2 or later, which needs no bash-completion package: completes verbs, options,
// words of values, and files where a file is expected.
std::string MakeBashCompletion(const CommandTable& program);

}  // namespace cairn

#endif  // CAIRN_CLI_MANUAL_BASH_COMPLETION_H_
