// `cairn info`: shows the contents of a map.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "cli/codebook_hint.h"
#include "cli/json_output.h"
#include "cli/shell.h"
#include "core/angles.h"
#include "core/printable.h"
#include "ingest/codebook/shipped_codebook.h"
#include "storage/codebook/codebook_digest.h"
#include "storage/map/map_store.h"

namespace cairn {
namespace {

struct InfoArguments {
  std::string map_path;
  bool json = false;
};

nlohmann::ordered_json BoundsJson(const MapInfo& info) {
  if (!info.bounds) {
    return nullptr;
  }
  return {{"west", info.bounds->west_rad * kDegPerRad},
          {"south", info.bounds->south_rad * kDegPerRad},
          {"east", info.bounds->east_rad * kDegPerRad},
          {"north", info.bounds->north_rad * kDegPerRad}};
}

// What is known of the codebook that codes new sessions.
struct CodebookFacts {
  std::string digest;
  bool is_shipped = false;
  std::optional<std::string> trained_on;  // The session, if known.
  std::optional<std::string> hint;        // If another codebook would help.
};

nlohmann::ordered_json OrNull(const std::optional<std::string>& text) {
  return text ? nlohmann::ordered_json(*text) : nlohmann::ordered_json(nullptr);
}

std::string OriginText(const CodebookFacts& codebook) {
  return codebook.is_shipped ? " (shipped)"
         : codebook.trained_on
             ? fmt::format(" (trained on session {})", Excerpt(*codebook.trained_on))
             : "";
}

nlohmann::ordered_json AccuracyJson(const std::optional<SessionAccuracy>& accuracy) {
  if (!accuracy) {
    return nullptr;
  }
  return {{"inMapM", accuracy->in_map_m},
          {"onEarthM", accuracy->on_earth_m},
          {"onEarthDeg", accuracy->on_earth_rad * kDegPerRad}};
}

std::string AccuracyText(const std::optional<SessionAccuracy>& accuracy) {
  return accuracy ? fmt::format(", accurate to {:.3f} m on Earth and {:.3f} m in the map (68 %)",
                                accuracy->on_earth_m, accuracy->in_map_m)
                  : "";
}

void PrintInfoAsJson(const MapInfo& info, const std::optional<CodebookFacts>& codebook,
                     const std::vector<SessionRecord>& sessions) {
  nlohmann::ordered_json json = {{"version", Value(info.version)},
                                 {"created", info.created_at},
                                 {"fileBytes", info.file_bytes},
                                 {"payloadBytes", info.payload_bytes},
                                 {"tiles", info.num_tiles},
                                 {"keyframes", info.num_keyframes},
                                 {"landmarks", info.num_landmarks},
                                 {"descriptors", info.num_descriptors},
                                 {"bounds", BoundsJson(info)},
                                 {"codebook", nullptr},
                                 {"sessions", nlohmann::ordered_json::array()}};
  if (codebook) {
    json["codebook"] = codebook->digest;
    json["codebookIsShipped"] = codebook->is_shipped;
    json["codebookTrainedOn"] = OrNull(codebook->trained_on);
    json["codebookHint"] = OrNull(codebook->hint);
  }
  for (const SessionRecord& session : sessions) {
    json["sessions"].push_back({{"name", session.name},
                                {"created", session.created_at},
                                {"recorded", session.recorded_at},
                                {"source", session.source},
                                {"images", session.num_images},
                                {"landmarksRead", session.num_landmarks},
                                {"georefMedianResidualM", session.georef_median_residual_m},
                                {"accuracy", AccuracyJson(session.accuracy)}});
  }
  PrintJson(json);
}

void PrintText(const MapInfo& info, const std::optional<CodebookFacts>& codebook,
               const std::vector<SessionRecord>& sessions) {
  fmt::print("version      {}\n", Value(info.version));
  fmt::print("created      {}\n", Excerpt(info.created_at));
  fmt::print("file         {:.1f} kB, including {:.1f} kB of tiles\n",
             1e-3 * static_cast<double>(info.file_bytes),
             1e-3 * static_cast<double>(info.payload_bytes));
  fmt::print("tiles        {}\n", info.num_tiles);
  fmt::print("keyframes    {}\n", info.num_keyframes);
  fmt::print("landmarks    {}\n", info.num_landmarks);
  fmt::print("descriptors  {}\n", info.num_descriptors);
  if (info.bounds) {
    fmt::print("bounds       {:.6f} to {:.6f} north, {:.6f} to {:.6f} east\n",
               info.bounds->south_rad * kDegPerRad, info.bounds->north_rad * kDegPerRad,
               info.bounds->west_rad * kDegPerRad, info.bounds->east_rad * kDegPerRad);
  }
  if (codebook) {
    fmt::print("codebook     {}{}\n", codebook->digest, OriginText(*codebook));
    if (codebook->hint) {
      fmt::print("hint         {}\n", *codebook->hint);
    }
  }
  for (const SessionRecord& session : sessions) {
    fmt::print(
        "session      {}: {} images, {} landmarks read, recorded {}, ingested {}, georegistration "
        "residual {:.3f} m{}\n",
        Excerpt(session.name), session.num_images, session.num_landmarks,
        Excerpt(session.recorded_at), Excerpt(session.created_at), session.georef_median_residual_m,
        AccuracyText(session.accuracy));
  }
}

// Returns nothing if the map has no codebook.
std::optional<CodebookFacts> FactsOfCodebook(const MapSnapshot& snapshot,
                                             const std::vector<SessionRecord>& sessions,
                                             const std::string& map_path) {
  const std::shared_ptr<const Codebook> codebook = snapshot.CurrentCodebook();
  if (codebook == nullptr) {
    return std::nullopt;
  }
  CodebookFacts facts;
  facts.digest = snapshot.CodebookDigest(codebook->id);
  facts.is_shipped = facts.digest == DigestOf(*ShippedCodebook());
  facts.trained_on =
      SessionThatTrained(snapshot.Versions(std::numeric_limits<int64_t>::max()), facts.is_shipped);
  if (const SessionRecord* session =
          SessionToTrainOn(sessions, facts.trained_on, facts.is_shipped)) {
    facts.hint = RecodeHint(*session, map_path);
  }
  return facts;
}

ExitCode RunInfo(const InfoArguments& arguments) {
  const MapStore store = MapStore::Open(arguments.map_path, OpenMode::kReadOnly);
  const MapSnapshot snapshot = store.Snapshot();
  const std::vector<SessionRecord> sessions = snapshot.Sessions();
  const std::optional<CodebookFacts> codebook =
      FactsOfCodebook(snapshot, sessions, arguments.map_path);
  if (arguments.json) {
    PrintInfoAsJson(snapshot.Info(), codebook, sessions);
  } else {
    PrintText(snapshot.Info(), codebook, sessions);
  }
  return ExitCode::kOk;
}

}  // namespace

void AddInfoCommand(CLI::App* app, Shell* shell) {
  CLI::App* command = app->add_subcommand("info", "Show the contents of a map");
  auto arguments = std::make_shared<InfoArguments>();
  command->add_option("MAP", arguments->map_path, "Map: a file or a postgresql:// URL")->required();
  AddJsonFlag(command, &arguments->json);
  command->footer("Example:\n  cairn info city.gpkg");
  command->callback(
      [shell, arguments] { shell->run = [arguments] { return RunInfo(*arguments); }; });
}

}  // namespace cairn
