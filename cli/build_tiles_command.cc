// `cairn build-tiles`: one of many tasks that build the tiles of a plan.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "cli/ingest_summary.h"
#include "cli/json_output.h"
#include "cli/shell.h"
#include "ingest/maps/run_plan.h"

namespace cairn {
namespace {

struct BuildTilesArguments {
  std::string plan;
  TaskShare share;
  bool json = false;
};

ExitCode RunBuildTiles(const BuildTilesArguments& arguments, ProgressMode progress_mode) {
  arguments.share.Validate();
  PlanFolder folder(arguments.plan);
  ShareReport report;
  {
    Progress progress(progress_mode);
    report =
        BuildShare(&folder, arguments.share, [&](const char* phase, int64_t done, int64_t total) {
          progress.Update(phase, done, total);
        });
  }
  if (arguments.json) {
    PrintJson({{"index", arguments.share.index},
               {"count", arguments.share.count},
               {"tiles", report.num_tiles},
               {"built", report.num_built}});
  } else {
    fmt::print("task {} of {}: {} tiles, {} of them built now\n", arguments.share.index,
               arguments.share.count, report.num_tiles, report.num_built);
  }
  return ExitCode::kOk;
}

}  // namespace

void AddBuildTilesCommand(CLI::App* app, Shell* shell) {
  CLI::App* command = app->add_subcommand("build-tiles", "Build a share of the tiles of a plan");
  auto arguments = std::make_shared<BuildTilesArguments>();
  command->add_option("--plan", arguments->plan, "Folder that cairn plan made")
      ->type_name("PLAN")
      ->required();
  command->add_option("--index", arguments->share.index, "Number of this task, from 0")->required();
  command->add_option("--count", arguments->share.count, "Number of tasks")->required();
  command->add_option("--threads", arguments->share.num_threads, "Threads that build tiles")
      ->capture_default_str();
  AddJsonFlag(command, &arguments->json);
  command->footer(
      "The task needs no map. It may be repeated and may be killed.\n"
      "Example:\n"
      "  cairn build-tiles --plan /shared/monday.plan --index 3 --count 20");
  command->callback([shell, arguments] {
    shell->run = [shell, arguments] { return RunBuildTiles(*arguments, shell->progress_mode); };
  });
}

}  // namespace cairn
