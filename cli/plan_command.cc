// `cairn plan`: the first of the three steps of an ingest on many machines.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "cli/ingest_summary.h"
#include "cli/join_summary.h"
#include "cli/json_output.h"
#include "cli/session_arguments.h"
#include "cli/session_replacement.h"
#include "cli/shell.h"
#include "core/parallel_for.h"
#include "core/printable.h"
#include "ingest/maps/plan_folder.h"
#include "ingest/plan_session.h"
#include "storage/map/map_store.h"

namespace cairn {
namespace {

struct PlanArguments {
  SessionArguments session;
  std::string out;
};

// `publish` may run in another folder.
std::string AbsoluteMapPath(const std::string& path) {
  return path.find("://") == std::string::npos ? std::filesystem::absolute(path).string() : path;
}

void PrintSummary(const PlanArguments& arguments, const Georegistration& georegistration,
                  const SessionPlan& plan) {
  if (arguments.session.json) {
    PrintJson({{"plan", arguments.out},
               {"session", plan.session.name},
               {"unchanged", plan.is_unchanged},
               {"georegistration", GeoregistrationJson(georegistration)},
               {"comparison", ComparisonJson(plan.comparison)},
               {"images", plan.session.num_images},
               {"landmarksRead", plan.session.num_landmarks},
               {"landmarksDropped", plan.num_landmarks_dropped},
               {"tiles", plan.tiles.size()},
               {"baseVersion", Value(plan.base_version)}});
    return;
  }
  fmt::print("session          {}{}\n", Excerpt(plan.session.name),
             plan.replaced_session != SessionId{} ? " (replaces the one of this name)" : "");
  PrintGeoregistration(georegistration);
  if (plan.is_unchanged) {
    fmt::print("The map already holds exactly this session. There is nothing to build.\n");
    return;
  }
  PrintComparison(plan.comparison, "photos");
  fmt::print("tiles            {}, from version {} of the map\n", plan.tiles.size(),
             Value(plan.base_version));
  fmt::print(
      "Next: cairn build-tiles --plan {0} --index I --count N for each I from 0 to N - 1, "
      "then cairn publish --plan {0}\n",
      Excerpt(arguments.out));
}

ExitCode RunPlan(const PlanArguments& arguments, ProgressMode progress_mode) {
  RequirePositions(arguments.session);
  MapStore store = MapStore::Open(arguments.session.map_path, OpenMode::kReadWrite);
  PreparePlanFolder(arguments.out);
  const PlacedReconstruction session = ReadSession(arguments.session);
  CheckReplacement(store.Snapshot(), session, HasSessionName(arguments.session));
  PlannedSession planned;
  {
    Progress progress(progress_mode);
    const auto show = [&](const char* phase, int64_t done, int64_t total) {
      progress.Update(phase, done, total);
    };
    planned = PlanSession(session.reconstruction, session.georegistration.ecef_from_world,
                          session.options, &store, show);
    WritePlan(planned, AbsoluteMapPath(arguments.session.map_path), arguments.out, show);
  }
  PrintSummary(arguments, session.georegistration, planned.plan);
  return ExitCode::kOk;
}

}  // namespace

void AddPlanCommand(CLI::App* app, Shell* shell) {
  CLI::App* command =
      app->add_subcommand("plan", "Prepare an ingest whose tiles other processes build");
  auto arguments = std::make_shared<PlanArguments>();
  arguments->session.options.ingest.num_threads = NumCores();
  AddSessionArguments(command, &arguments->session);
  command
      ->add_option("--out", arguments->out,
                   "Folder for the plan, on a file system that all machines share; made if needed")
      ->type_name("PLAN")
      ->required();
  command->footer(
      "Example:\n"
      "  cairn plan city.gpkg --model sparse/0 --database database.db --gps --session monday \\\n"
      "      --out /shared/monday.plan");
  command->callback([shell, arguments] {
    shell->run = [shell, arguments] { return RunPlan(*arguments, shell->progress_mode); };
  });
}

}  // namespace cairn
