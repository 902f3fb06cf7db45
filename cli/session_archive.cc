#include "cli/session_archive.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "cli/options/read_options.h"
#include "cli/options/write_options.h"
#include "core/error.h"
#include "core/printable.h"
#include "ingest/codebook/choose_codebook.h"
#include "ingest/codebook/shipped_codebook.h"
#include "ingest/maps/archive_session.h"

namespace cairn {
namespace {

// The section of the ingest alone, so that an archive outlives options of other verbs.
std::string IngestOptionsAsJson(const CairnOptions& options) {
  const auto all = nlohmann::ordered_json::parse(OptionsAsJson(options));
  return nlohmann::ordered_json({{"ingest", all.at("ingest")}}).dump();
}

// Requires that the archive has no session that the map got after `session`.
void RequireNoneAfter(const MapSession& session, const ArchiveFolder& folder,
                      const MapSnapshot& map) {
  for (const MapSession& other : MapSessionsOf(map)) {
    if (Value(other.id) > Value(session.id) && folder.Holds(other.key)) {
      throw Error(ErrorCode::kConflict,
                  fmt::format("{}: the archive has session '{}' already, which came after '{}'. "
                              "Archive the first session of the map first",
                              folder.path(), Excerpt(other.key.name), Excerpt(session.key.name)));
    }
  }
}

// Requires that an ingest of the first session would give a new map a codebook as the map has it:
// the digest of a session does not tell with which options of the codebook it was ingested.
void RequireCodebookOf(const MapSnapshot& map, const Reconstruction& reconstruction,
                       const CodebookOptions& options) {
  const auto in_map = map.CurrentCodebook();
  const auto again = ChooseCodebook(reconstruction, options);
  if (IsShipped(*in_map) != IsShipped(*again) ||
      in_map->projected_dim() != again->projected_dim() ||
      in_map->num_subspaces != again->num_subspaces) {
    throw Error(ErrorCode::kConflict,
                fmt::format("the map has another codebook than these options give; to archive the "
                            "session, ingest it again with --codebook {} --code-bytes {} and the "
                            "other options of its first ingest",
                            IsShipped(*in_map) ? "shipped" : "trained", in_map->num_subspaces));
  }
}

void PrintNames(const char* what, const std::vector<std::string>& names) {
  if (!names.empty()) {
    fmt::print("                 {}: {}\n", what,
               Excerpt(fmt::format("{}", fmt::join(names, ", "))));
  }
}

}  // namespace

SessionArchive::SessionArchive(const std::string& path, const std::string& session_name,
                               const MapStore& map)
    : folder_(path, ArchiveFolder::Use::kIngest) {
  folder_.Recover(ArchivedMapOf(map.Snapshot()), session_name);
}

void SessionArchive::Stage(const PlannedSession& planned, const Sim3d& ecef_from_world,
                           const CairnOptions& options) {
  const ArchiveManifest manifest =
      MakeManifest(planned, ecef_from_world, options.ingest, IngestOptionsAsJson(options));
  if (planned.plan.is_unchanged) {
    if (folder_.Holds(manifest.session)) {
      return;
    }
    RequireNoneAfter({manifest.session, manifest.first_ids.session}, folder_, *planned.base);
    if (manifest.earlier_sessions.empty()) {
      RequireCodebookOf(*planned.base, *planned.reconstruction, options.ingest.codebook);
    }
  }
  folder_.Stage(manifest, *planned.reconstruction);
  is_staged_ = true;
  if (paths_ != nullptr) {
    paths_->push_back(folder_.files().back().path);
  }
}

void SessionArchive::Commit() {
  if (std::exchange(is_staged_, false)) {
    file_ = folder_.Commit();
  }
}

void SessionArchive::Print(const MapStore& map) const {
  if (!file_.empty()) {
    fmt::print("archive          {}\n", Printable(file_));
  }
  const MapSnapshot snapshot = map.Snapshot();
  std::vector<std::string> only_in_map;
  for (const MapSession& session : MapSessionsOf(snapshot)) {
    if (!folder_.Holds(session.key)) {
      only_in_map.push_back(session.key.name);
    }
  }
  std::vector<std::string> only_here;
  for (const ArchiveFile& file : folder_.files()) {
    if (!snapshot.FindSession(file.manifest.session.name)) {
      only_here.push_back(file.manifest.session.name);
    }
  }
  PrintNames("lacks sessions of the map", only_in_map);
  PrintNames("has sessions that the map does not have", only_here);
}

IngestOptions IngestOptionsOf(const ArchiveFile& file) {
  CairnOptions options;
  try {
    ReadOptions(file.manifest.options_json, &options);
  } catch (const Error& error) {
    throw Error(ErrorCode::kMapDamaged, file.path + ": " + error.what());
  }
  return options.ingest;
}

}  // namespace cairn
