// `cairn ingest`: adds a reconstruction to a map as one session.
#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "cli/ingest_placed.h"
#include "cli/ingest_summary.h"
#include "cli/session_archive.h"
#include "cli/session_arguments.h"
#include "cli/session_replacement.h"
#include "cli/shell.h"
#include "core/parallel_for.h"
#include "storage/map/map_store.h"

namespace cairn {
namespace {

struct IngestArguments {
  SessionArguments session;
  std::string archive_path;  // Empty: no archive.
};

ExitCode RunIngest(const IngestArguments& arguments, ProgressMode progress_mode) {
  RequirePositions(arguments.session);
  // Open the map and the archive first, so that an unwritable one fails before the long read.
  MapStore store = MapStore::Open(arguments.session.map_path, OpenMode::kReadWrite);
  const std::unique_ptr<SessionArchive> archive =
      OpenSessionArchive(arguments.archive_path, SessionNameOf(arguments.session), store);
  const PlacedReconstruction session = ReadSession(arguments.session);
  CheckReplacement(store.Snapshot(), session, HasSessionName(arguments.session));
  IngestReport report;
  {
    Progress progress(progress_mode);
    report = IngestPlaced(
        session, arguments.session.options, archive.get(),
        [&](const char* phase, int64_t done, int64_t total) {
          progress.Update(phase, done, total);
        },
        &store);
  }
  const auto print = arguments.session.json ? PrintIngestJson : PrintIngestText;
  print(session.options.session_name, session.georegistration, report);
  if (archive != nullptr && !arguments.session.json) {
    archive->Print(store);
  }
  return ExitCode::kOk;
}

}  // namespace

void AddIngestCommand(CLI::App* app, Shell* shell) {
  CLI::App* command = app->add_subcommand("ingest", "Add a COLMAP reconstruction to a map");
  auto arguments = std::make_shared<IngestArguments>();
  IngestOptions& options = arguments->session.options.ingest;
  options.num_threads = NumCores();
  AddSessionArguments(command, &arguments->session);
  command
      ->add_option("--threads", options.num_threads,
                   "Threads that build tiles; the result does not depend on them. Default: all "
                   "cores")
      ->check(CLI::PositiveNumber);
  command
      ->add_option(
          "--archive", arguments->archive_path,
          "Folder that keeps the session as it is ingested, for cairn rebuild. Made if there "
          "is none. One folder for each map")
      ->type_name("DIR");
  command->footer(
      "Example:\n"
      "  cairn ingest city.gpkg --model sparse/0 --database database.db --gps --session monday");
  command->callback([shell, arguments] {
    shell->run = [shell, arguments] { return RunIngest(*arguments, shell->progress_mode); };
  });
}

}  // namespace cairn
