// A plan on disk: a folder that all tasks of a build see (docs/formats/plan_v1.md).
#ifndef CAIRN_INGEST_MAPS_PLAN_FOLDER_H_
#define CAIRN_INGEST_MAPS_PLAN_FOLDER_H_

#include <cstddef>
#include <optional>
#include <string>

#include "ingest/maps/plan_json.h"
#include "ingest/plan_session.h"
#include "ingest/session_tile_builder.h"

namespace cairn {

// Makes an empty folder for a plan, and removes what a `cairn plan` that died left there. Throws
// Error(kConflict) if the folder holds a plan or other files, Error(kIo) if it cannot be made.
void PreparePlanFolder(const std::string& path);

// Writes shards, codebook and, last, the manifest into a prepared folder. A process that dies
// leaves no manifest. Throws Error(kIo), and what PlannedSession::Shard throws. Reports "shards".
void WritePlan(const PlannedSession& planned, const std::string& map_path, const std::string& path,
               const IngestProgress& progress);

// An open plan. Any number of processes may use it at a time.
class PlanFolder {
 public:
  // Reads the manifest. Throws Error(kNotFound) if there is none, Error(kBadInput) if it is damaged
  // or of another version of Cairn.
  explicit PlanFolder(const std::string& path);

  const std::string& path() const { return path_; }
  // Before LoadCodebook, the codebook has only its id.
  const SessionPlan& plan() const { return manifest_.plan; }
  const std::string& map_path() const { return manifest_.map_path; }

  // Throw Error(kBadInput) if the file is missing or is not the one that the manifest names.
  void LoadCodebook();
  TileShard LoadShard(size_t tile_idx) const;

  // Gives the result its name in one step: there is all of it or nothing. Tasks that build the same
  // tile at the same time write the same bytes. Throws Error(kIo).
  void StoreResult(size_t tile_idx, const BuiltTile& built) const;
  // Returns nothing if there is no result, or a damaged one, or one of another plan.
  std::optional<BuiltTile> LoadResult(size_t tile_idx) const;
  bool HasResult(size_t tile_idx) const;  // Does not look into it.

  // Removes what tasks that died have left of tiles that have a result.
  void RemoveUnfinished() const;
  // Removes shards, results, and what tasks that died have left. The manifest stays.
  void RemoveContent() const;

 private:
  std::string ShardPath(size_t tile_idx) const;
  std::string ResultPath(size_t tile_idx) const;

  std::string path_;
  std::string digest_;  // Of the manifest; results name it.
  PlanManifest manifest_;
};

}  // namespace cairn

#endif  // CAIRN_INGEST_MAPS_PLAN_FOLDER_H_
