// `cairn publish`: makes the built tiles of a plan the next version of the map.
#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "cli/ingest_summary.h"
#include "cli/json_output.h"
#include "cli/session_arguments.h"
#include "cli/shell.h"
#include "core/parallel_for.h"
#include "ingest/maps/run_plan.h"
#include "storage/map/map_store.h"

namespace cairn {
namespace {

struct PublishArguments {
  std::string plan;
  std::string map_path;  // Empty: that of the plan.
  int64_t num_tasks = 0;
  double wait_s = 30.0;
  bool force = false;
  bool json = false;
};

ExitCode RunPublish(const PublishArguments& arguments, ProgressMode progress_mode) {
  PlanFolder folder(arguments.plan);
  MapStore store = MapStore::Open(
      arguments.map_path.empty() ? folder.map_path() : arguments.map_path, OpenMode::kReadWrite);
  IngestReport report;
  {
    Progress progress(progress_mode);
    const PublishOptions options = {.patience = PatienceOf(arguments.wait_s),
                                    .num_threads = NumCores(),
                                    .force = arguments.force};
    report = PublishPlan(&folder, arguments.num_tasks, &store, options,
                         [&](const char* phase, int64_t done, int64_t total) {
                           progress.Update(phase, done, total);
                         });
  }
  const SessionRecord& session = folder.plan().session;
  Georegistration georegistration;
  georegistration.median_residual_m = session.georef_median_residual_m;
  const auto print = arguments.json ? PrintIngestJson : PrintIngestText;
  print(session.name, georegistration, report);
  return ExitCode::kOk;
}

}  // namespace

void AddPublishCommand(CLI::App* app, Shell* shell) {
  CLI::App* command =
      app->add_subcommand("publish", "Publish a plan whose tiles are built as a new version");
  auto arguments = std::make_shared<PublishArguments>();
  command->add_option("--plan", arguments->plan, "Folder that cairn plan made")
      ->type_name("PLAN")
      ->required();
  command
      ->add_option("--map", arguments->map_path,
                   "The map under the name that it has here. Default: as cairn plan named it")
      ->type_name("MAP");
  command
      ->add_option("--count", arguments->num_tasks,
                   "Number of tasks that built the tiles, to name those to run again")
      ->check(CLI::PositiveNumber)
      ->type_name("N");
  AddWaitOption(command, &arguments->wait_s);
  AddForceFlag(command, &arguments->force);
  AddJsonFlag(command, &arguments->json);
  command->footer(
      "Removes shards and results from the folder once they are published.\n"
      "Example:\n"
      "  cairn publish --plan /shared/monday.plan --count 20");
  command->callback([shell, arguments] {
    shell->run = [shell, arguments] { return RunPublish(*arguments, shell->progress_mode); };
  });
}

}  // namespace cairn
