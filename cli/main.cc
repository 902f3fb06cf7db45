// The `cairn` binary, with the verbs for users of maps.
#include "cli/run_program.h"
#include "cli/shell.h"

namespace cairn {
namespace {

void AddVerbs(CLI::App* app, Shell* shell) {
  AddInitCommand(app, shell);
  AddMapCommand(app, shell);
  AddIngestCommand(app, shell);
  AddPlanCommand(app, shell);
  AddBuildTilesCommand(app, shell);
  AddPublishCommand(app, shell);
  AddRemoveCommand(app, shell);
  AddRebuildCommand(app, shell);
  AddServeCommand(app, shell);
  AddKeysCommand(app, shell);
  AddLocalizeCommand(app, shell);
  AddEvalCommand(app, shell);
  AddInfoCommand(app, shell);
  AddSqlCommand(app, shell);
  AddCheckCommand(app, shell);
  AddOptionsCommand(app, shell);
  AddLogCommand(app, shell);
  AddDiffCommand(app, shell);
  AddRollbackCommand(app, shell);
  AddPruneCommand(app, shell);
  AddCopyCommand(app, shell);
  AddMergeCommand(app, shell);
  AddRecodeCommand(app, shell);
  AddExtractCommand(app, shell);
  AddExportCommand(app, shell);
  AddCompactCommand(app, shell);
  AddDemoCommand(app, shell);
}

}  // namespace
}  // namespace cairn

int main(int argc, char** argv) {
  return cairn::RunProgram(
      {"cairn",
       "Cairn, a visual positioning system: computes six-degree-of-freedom poses from photos.",
       cairn::AddVerbs, cairn::ThisBuild()},
      argc, argv);
}
