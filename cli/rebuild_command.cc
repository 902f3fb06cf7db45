// `cairn rebuild`: makes a map of archived sessions.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "cli/json_output.h"
#include "cli/session_archive.h"
#include "cli/shell.h"
#include "core/error.h"
#include "core/parallel_for.h"
#include "core/printable.h"
#include "ingest/maps/archive_session.h"
#include "ingest/maps/rebuild_plan.h"

namespace cairn {
namespace {

struct RebuildArguments {
  std::string map_path;
  std::string archive_path;
  std::vector<std::string> without;
  int num_threads = NumCores();
  bool json = false;
};

void IngestFile(const ArchiveFile& file, const RebuildArguments& arguments, MapStore* store,
                Progress* progress) {
  IngestOptions options = IngestOptionsOf(file);
  options.num_threads = arguments.num_threads;
  const ArchivedSession session = ReadArchivedSession(file.path);
  // Without a session, the map gets the ids of a map that never had it.
  const Numbering numbering = arguments.without.empty() ? Numbering::kAsBefore : Numbering::kDense;
  try {
    IngestAgain(session, options, numbering, store,
                [&](const char* phase, int64_t done, int64_t total) {
                  progress->Update(phase, done, total);
                });
  } catch (const Error& error) {
    throw Error(error.code(), fmt::format("{}: {}", file.path, error.what()));
  }
}

void PrintRebuildAsJson(const RebuildArguments& arguments, const std::vector<ArchiveFile>& plan,
                        const MapInfo& info) {
  nlohmann::ordered_json json = {{"map", arguments.map_path},
                                 {"mapVersion", Value(info.version)},
                                 {"ingested", nlohmann::ordered_json::array()}};
  for (const ArchiveFile& file : plan) {
    json["ingested"].push_back(file.manifest.session.name);
  }
  json.update(TotalsJson(info));
  PrintJson(json);
}

void PrintRebuild(const RebuildArguments& arguments, const std::vector<ArchiveFile>& plan,
                  const MapInfo& info) {
  for (const ArchiveFile& file : plan) {
    fmt::print("session      {}\n", Excerpt(file.manifest.session.name));
  }
  fmt::print("{}: version {}, {} sessions, {} tiles, {} landmarks, {:.1f} kB\n",
             Printable(arguments.map_path), Value(info.version), info.num_sessions, info.num_tiles,
             info.num_landmarks, 1e-3 * static_cast<double>(info.payload_bytes));
}

ExitCode RunRebuild(const RebuildArguments& arguments, ProgressMode progress_mode) {
  const ArchiveFolder archive(arguments.archive_path, ArchiveFolder::Use::kRebuild);
  const std::vector<ArchiveFile> plan = PlanRebuild(archive, arguments.without);
  MapInfo info;
  MapStore::CreateFilled(arguments.map_path, [&](MapStore* store) {
    Progress progress(progress_mode);
    for (const ArchiveFile& file : plan) {
      IngestFile(file, arguments, store, &progress);
    }
    info = store->Snapshot().Info();
  });
  const auto print = arguments.json ? PrintRebuildAsJson : PrintRebuild;
  print(arguments, plan, info);
  return ExitCode::kOk;
}

}  // namespace

void AddRebuildCommand(CLI::App* app, Shell* shell) {
  CLI::App* command =
      app->add_subcommand("rebuild", "Make a map of the sessions that cairn ingest archived");
  auto arguments = std::make_shared<RebuildArguments>();
  command
      ->add_option("MAP", arguments->map_path,
                   "Map to create: a file, or the URL of a PostgreSQL database")
      ->required();
  command
      ->add_option("--archive", arguments->archive_path,
                   "Folder that cairn ingest --archive has written")
      ->type_name("DIR")
      ->required();
  command
      ->add_option("--without", arguments->without,
                   "Leave this session out, as if it had never been ingested. May be repeated")
      ->type_name("SESSION")
      ->allow_extra_args(false);
  command
      ->add_option("--threads", arguments->num_threads,
                   "Threads that build tiles; the result does not depend on them. Default: all "
                   "cores")
      ->check(CLI::PositiveNumber);
  AddJsonFlag(command, &arguments->json);
  command->footer(
      "Example:\n  cairn rebuild without_monday.gpkg --archive sessions --without monday");
  command->callback([shell, arguments] {
    shell->run = [shell, arguments] { return RunRebuild(*arguments, shell->progress_mode); };
  });
}

}  // namespace cairn
