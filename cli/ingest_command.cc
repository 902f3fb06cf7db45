// `cairn ingest`: adds a reconstruction to a map as one session.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <thread>

#include "cli/ingest_summary.h"
#include "cli/session_arguments.h"
#include "cli/shell.h"
#include "ingest/ingest_session.h"
#include "storage/map/map_store.h"

namespace cairn {
namespace {

ExitCode RunIngest(const SessionArguments& arguments, ProgressMode progress_mode) {
  RequirePositions(arguments);
  // Open the map first, so that an unwritable map fails before the long read.
  MapStore store = MapStore::Open(arguments.map_path, OpenMode::kReadWrite);
  const PlacedReconstruction session = ReadSession(arguments);
  IngestReport report;
  {
    Progress progress(progress_mode);
    report =
        IngestSession(session.reconstruction, session.georegistration.ecef_from_world,
                      session.options, &store, [&](const char* phase, int64_t done, int64_t total) {
                        progress.Update(phase, done, total);
                      });
  }
  const auto print = arguments.json ? PrintIngestJson : PrintIngestText;
  print(session.options.session_name, session.georegistration, report);
  return ExitCode::kOk;
}

}  // namespace

void AddIngestCommand(CLI::App* app, Shell* shell) {
  CLI::App* command = app->add_subcommand("ingest", "Add a COLMAP reconstruction to a map");
  auto arguments = std::make_shared<SessionArguments>();
  arguments->options.ingest.num_threads =
      std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  AddSessionArguments(command, arguments.get());
  command
      ->add_option("--threads", arguments->options.ingest.num_threads,
                   "Threads that build tiles; the result does not depend on them. Default: all "
                   "cores")
      ->check(CLI::PositiveNumber);
  command->footer(
      "Example:\n"
      "  cairn ingest city.gpkg --model sparse/0 --database database.db --gps --session monday");
  command->callback([shell, arguments] {
    shell->run = [shell, arguments] { return RunIngest(*arguments, shell->progress_mode); };
  });
}

}  // namespace cairn
