// The versions of a map: a description of each published update, and the differences of two.
#ifndef CAIRN_STORAGE_MAP_MAP_VERSIONS_H_
#define CAIRN_STORAGE_MAP_MAP_VERSIONS_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/geodesy.h"
#include "core/tile_id.h"
#include "storage/ids.h"

namespace cairn {

// The size of a map in one version.
struct MapTotals {
  int64_t num_sessions = 0;
  int64_t num_keyframes = 0;
  int64_t num_tiles = 0;
  int64_t num_landmarks = 0;  // Sum over tiles; a landmark in two tiles counts twice.
  int64_t num_descriptors = 0;
  int64_t payload_bytes = 0;
  std::optional<GeoBox> bounds;  // Around the tiles' squares; empty if the map is empty.
};

enum class VersionKind {
  kEdit,  // An update without a description.
  kCreate,
  kIngest,
  kReplace,  // An ingest that replaces a session of the same name.
  kRemove,
  kRollback,
  kPrune,
  kMerge,
  kExtract,
  kRecode,
};

// "ingest", "rollback", ...: the words of cairn_versions.kind.
const char* VersionKindName(VersionKind kind);

// Describes an update for people.
struct VersionNote {
  VersionKind kind = VersionKind::kEdit;
  std::string session = {};  // The name of the session concerned, or empty.
  std::string summary = {};  // One line.
};

// A published update.
struct VersionRecord {
  MapVersion version{};
  std::string created_at;  // UTC, RFC 3339.
  std::string author;      // The login name of the publisher.
  std::string kind;        // A value of VersionKindName, or a word of a newer Cairn.
  std::string session;
  std::string summary;
  MapTotals totals;
};

// A tile in one version.
struct TileState {
  PayloadId payload_id{};
  std::string digest;  // XXH3-128 of the payload, 32 hexadecimal digits.
  int64_t num_landmarks = 0;
  int64_t num_bytes = 0;
};

// A tile that differs between two versions. At least one of the states is set.
struct TileChange {
  TileId tile_id;
  std::optional<TileState> before;
  std::optional<TileState> after;
};

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_MAP_VERSIONS_H_
