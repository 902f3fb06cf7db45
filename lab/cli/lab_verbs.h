// The verbs of the `cairn-lab` binary; see cli/shell.h.
#ifndef CAIRN_LAB_CLI_LAB_VERBS_H_
#define CAIRN_LAB_CLI_LAB_VERBS_H_

#include "cli/shell.h"

namespace cairn {

void AddBenchCommand(CLI::App* app, Shell* shell);
void AddCodebookCommand(CLI::App* app, Shell* shell);
void AddExperimentCommand(CLI::App* app, Shell* shell);
void AddSimulateCommand(CLI::App* app, Shell* shell);

}  // namespace cairn

#endif  // CAIRN_LAB_CLI_LAB_VERBS_H_
