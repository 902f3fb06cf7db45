// `cairn recode`: codes a map with another codebook.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "cli/json_output.h"
#include "cli/shell.h"
#include "core/printable.h"
#include "ingest/codebook/load_codebook.h"
#include "ingest/maps/recode_map.h"
#include "storage/codebook/codebook_digest.h"
#include "storage/map/map_store.h"

namespace cairn {
namespace {

struct RecodeArguments {
  std::string map_path;
  std::string codebook;
  bool json = false;
};

ExitCode RunRecode(const RecodeArguments& arguments, ProgressMode progress_mode) {
  MapStore store = MapStore::Open(arguments.map_path, OpenMode::kReadWrite);
  const std::shared_ptr<const Codebook> codebook = LoadCodebook(arguments.codebook);
  RecodeReport report;
  {
    Progress progress(progress_mode);
    report = RecodeMap(*codebook, &store, [&](int64_t done, int64_t total) {
      progress.Update("recode", done, total);
    });
  }
  if (arguments.json) {
    PrintJson({{"mapVersion", Value(report.map_version)},
               {"codebook", DigestOf(*codebook)},
               {"tiles", report.num_tiles},
               {"descriptors", report.num_descriptors},
               {"payloadBytesBefore", report.num_bytes_before},
               {"payloadBytes", report.num_bytes_after}});
    return ExitCode::kOk;
  }
  fmt::print(
      "{}: version {}, {} descriptors in {} tiles coded with codebook {}; {:.1f} kB before, {:.1f} "
      "kB now\n",
      Printable(arguments.map_path), Value(report.map_version), report.num_descriptors,
      report.num_tiles, DigestOf(*codebook), 1e-3 * static_cast<double>(report.num_bytes_before),
      1e-3 * static_cast<double>(report.num_bytes_after));
  return ExitCode::kOk;
}

}  // namespace

void AddRecodeCommand(CLI::App* app, Shell* shell) {
  CLI::App* command =
      app->add_subcommand("recode", "Code a map with another codebook, as a new version");
  auto arguments = std::make_shared<RecodeArguments>();
  command->add_option("MAP", arguments->map_path, "Map: a file or a postgresql:// URL")->required();
  command
      ->add_option("--codebook", arguments->codebook,
                   "Where the codebook comes from: the word shipped, another map, or a file of "
                   "cairn-lab codebook")
      ->required()
      ->type_name("shipped|MAP|FILE");
  AddJsonFlag(command, &arguments->json);
  command->footer(
      "Recoding loses a little of each descriptor. cairn rollback undoes it without loss. An "
      "empty\n"
      "map gets the codebook for its first session.\n"
      "Example:\n"
      "  cairn recode south.gpkg --codebook north.gpkg\n"
      "  cairn merge north.gpkg south.gpkg --out city.gpkg");
  command->callback([shell, arguments] {
    shell->run = [shell, arguments] { return RunRecode(*arguments, shell->progress_mode); };
  });
}

}  // namespace cairn
