// State that verbs share, and the functions that add verbs to the command line.
#ifndef CAIRN_CLI_SHELL_H_
#define CAIRN_CLI_SHELL_H_

#include <functional>
#include <string>

#include "cli/exit_codes.h"
#include "cli/progress.h"

namespace CLI {
class App;
}  // namespace CLI

namespace cairn {

// The global options and the verb selected by the command line.
struct Shell {
  ProgressMode progress_mode = ProgressMode::kAuto;
  std::function<ExitCode()> run;  // Throws Error.
  std::string commit;             // That the program was built from; empty if it is unknown.
  std::string program_path;       // As the command line named the program.
};

// Each function adds its verb to `app`. If the command line selects the verb, `shell->run` becomes
// its action.
void AddInitCommand(CLI::App* app, Shell* shell);
void AddMapCommand(CLI::App* app, Shell* shell);
void AddIngestCommand(CLI::App* app, Shell* shell);
void AddPlanCommand(CLI::App* app, Shell* shell);
void AddBuildTilesCommand(CLI::App* app, Shell* shell);
void AddPublishCommand(CLI::App* app, Shell* shell);
void AddRemoveCommand(CLI::App* app, Shell* shell);
void AddRebuildCommand(CLI::App* app, Shell* shell);
void AddServeCommand(CLI::App* app, Shell* shell);
void AddLocalizeCommand(CLI::App* app, Shell* shell);
void AddEvalCommand(CLI::App* app, Shell* shell);
void AddKeysCommand(CLI::App* app, Shell* shell);
void AddInfoCommand(CLI::App* app, Shell* shell);
void AddSqlCommand(CLI::App* app, Shell* shell);
void AddCheckCommand(CLI::App* app, Shell* shell);
void AddOptionsCommand(CLI::App* app, Shell* shell);
void AddLogCommand(CLI::App* app, Shell* shell);
void AddDiffCommand(CLI::App* app, Shell* shell);
void AddRollbackCommand(CLI::App* app, Shell* shell);
void AddPruneCommand(CLI::App* app, Shell* shell);
void AddCopyCommand(CLI::App* app, Shell* shell);
void AddMergeCommand(CLI::App* app, Shell* shell);
void AddRecodeCommand(CLI::App* app, Shell* shell);
void AddExtractCommand(CLI::App* app, Shell* shell);
void AddExportCommand(CLI::App* app, Shell* shell);
void AddCompactCommand(CLI::App* app, Shell* shell);
void AddDemoCommand(CLI::App* app, Shell* shell);

}  // namespace cairn

#endif  // CAIRN_CLI_SHELL_H_
