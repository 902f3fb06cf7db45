// The `cairn-lab` binary: simulated cities, the paper's experiments and benchmarks.
#include "cli/run_program.h"
#include "lab/cli/lab_verbs.h"

namespace cairn {
namespace {

void AddVerbs(CLI::App* app, Shell* shell) {
  AddSimulateCommand(app, shell);
  AddExperimentCommand(app, shell);
  AddBenchCommand(app, shell);
  AddCodebookCommand(app, shell);
}

}  // namespace
}  // namespace cairn

int main(int argc, char** argv) {
  return cairn::RunProgram(
      {"cairn-lab", "Cairn's laboratory: simulated cities, experiments and benchmarks.",
       cairn::AddVerbs, cairn::ThisBuild()},
      argc, argv);
}
