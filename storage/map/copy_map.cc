#include "storage/map/copy_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "core/error.h"
#include "storage/database/transaction.h"
#include "storage/inspection/geopackage.h"
#include "storage/map/internal/accuracy_table.h"
#include "storage/map/internal/id_counters.h"
#include "storage/map/internal/layer_extent.h"
#include "storage/map/internal/map_backend.h"
#include "storage/tile/content_digest.h"

namespace cairn {
namespace {

enum class Type { kInteger, kReal, kText, kBytes };

struct Column {
  const char* name;
  Type type = Type::kInteger;
};

using Columns = std::vector<Column>;

struct Table {
  const char* name;
  Columns columns;
};

Columns operator+(Columns columns, const Columns& more) {
  columns.insert(columns.end(), more.begin(), more.end());
  return columns;
}

// Columns that a table of the latest version and its table of the past have in common.

Columns SessionColumns() {
  return {{"name", Type::kText},
          {"source", Type::kText},
          {"created_at", Type::kText},
          {"recorded_at", Type::kText},
          {"content_digest", Type::kText},
          {"num_images"},
          {"num_landmarks"},
          {"georef_median_residual_m", Type::kReal}};
}

Columns TileCounts() {
  return {{"num_landmarks"}, {"num_descriptors"},      {"num_keyframes"},
          {"num_bytes"},     {"min_h_m", Type::kReal}, {"max_h_m", Type::kReal}};
}

Columns LandmarkBox() {
  return {{"landmarks_south_deg", Type::kReal},
          {"landmarks_west_deg", Type::kReal},
          {"landmarks_north_deg", Type::kReal},
          {"landmarks_east_deg", Type::kReal}};
}

Columns PoseColumns() {
  return {{"camera_id"},       {"qw", Type::kReal},   {"qx", Type::kReal},   {"qy", Type::kReal},
          {"qz", Type::kReal}, {"tx_m", Type::kReal}, {"ty_m", Type::kReal}, {"tz_m", Type::kReal}};
}

// The tables in an order in which rows refer only to earlier rows. Payloads are copied between the
// two lists, one at a time, because they are large.
std::vector<Table> TablesBeforePayloads() {
  return {
      {"cairn_codebooks",
       {{"codebook_id"},
        {"created_at", Type::kText},
        {"digest", Type::kText},
        {"bytes", Type::kBytes}}},
      {"cairn_map",
       {{"map_id"},
        {"format_version"},
        {"oldest_reader_version"},
        {"created_at", Type::kText},
        {"next_landmark_id"},
        {"codebook_id"}}},
      {"cairn_versions",
       {{"version"},
        {"created_at", Type::kText},
        {"author", Type::kText},
        {"kind", Type::kText},
        {"session", Type::kText},
        {"summary", Type::kText},
        {"codebook_id"},
        {"num_sessions"},
        {"num_keyframes"},
        {"num_tiles"},
        {"num_landmarks"},
        {"num_descriptors"},
        {"payload_bytes"},
        {"south_deg", Type::kReal},
        {"west_deg", Type::kReal},
        {"north_deg", Type::kReal},
        {"east_deg", Type::kReal}}},
      {"cairn_sessions", Columns{{"session_id"}} + SessionColumns() + Columns{{"since"}}},
      {"cairn_past_sessions", Columns{{"session_id"}, {"since"}, {"until"}} + SessionColumns()},
      {"cairn_cameras",
       {{"camera_id"},
        {"model", Type::kText},
        {"width_px"},
        {"height_px"},
        {"params", Type::kText}}},
  };
}

std::vector<Table> TablesAfterPayloads() {
  return {
      {"coverage", Columns{{"tile_id"}, {"tile", Type::kText}} + TileCounts()},
      {"cairn_tiles",
       Columns{{"tile_id"}, {"payload_id"}, {"codebook_id"}} + LandmarkBox() + Columns{{"since"}}},
      {"cairn_past_tiles", Columns{{"tile_id"},
                                   {"since"},
                                   {"until"},
                                   {"tile", Type::kText},
                                   {"payload_id"},
                                   {"codebook_id"}} +
                               TileCounts() + LandmarkBox()},
      {"keyframes",
       {{"keyframe_id"},
        {"session_id"},
        {"tile_id"},
        {"image_name", Type::kText},
        {"lat_deg", Type::kReal},
        {"lon_deg", Type::kReal},
        {"h_m", Type::kReal},
        {"heading_deg", Type::kReal}}},
      {"cairn_keyframe_poses", Columns{{"keyframe_id"}} + PoseColumns() + Columns{{"since"}}},
      {"cairn_past_keyframes", Columns{{"keyframe_id"},
                                       {"since"},
                                       {"until"},
                                       {"session_id"},
                                       {"tile_id"},
                                       {"image_name", Type::kText}} +
                                   PoseColumns()},
      {"cairn_session_tiles", {{"session_id"}, {"tile_id"}}},
  };
}

// Maps of earlier programs lack this table.
Table AccuracyTable() {
  return {accuracy_table::kName,
          {{"session_id"},
           {"in_map_m", Type::kReal},
           {"on_earth_m", Type::kReal},
           {"on_earth_rad", Type::kReal}}};
}

// Returns the geometry of a row, which follows from its other columns; empty if the table has none.
std::vector<uint8_t> GeometryOf(const std::string& table, const db::Statement& row) {
  if (table == "coverage") {
    return TileGeometry(TileId::FromValue(static_cast<uint64_t>(row.Int64(0))));
  }
  if (table == "keyframes") {
    return PointGeometry(Geodetic::FromDegrees(row.Double(4), row.Double(5), row.Double(6)));
  }
  return {};
}

std::vector<std::string> NamesOf(const Table& table) {
  std::vector<std::string> names;
  for (const Column& column : table.columns) {
    names.emplace_back(column.name);
  }
  return names;
}

class MapCopier {
 public:
  MapCopier(db::Connection* from, db::Connection* to) : from_(from), to_(to) {}

  void Run(const std::function<void(int64_t, int64_t)>& progress) {
    to_->Execute("DELETE FROM cairn_versions; DELETE FROM cairn_map");  // The empty map's rows.
    for (const Table& table : TablesBeforePayloads()) {
      CopyTable(table);
    }
    CopyPayloads(progress);
    for (const Table& table : TablesAfterPayloads()) {
      CopyTable(table);
    }
    if (accuracy_table::Exists(from_)) {
      CopyTable(AccuracyTable());
    }
    CopyCounters();
    if (to_->dialect() == db::Dialect::kSqlite) {
      LayerExtents(to_).Write(to_);
    }
  }

 private:
  void CopyTable(const Table& table) {
    const std::vector<std::string> names = NamesOf(table);
    db::Statement row = from_->Prepare(
        fmt::format("SELECT {} FROM {} ORDER BY 1", fmt::join(names, ", "), table.name));
    const bool has_geometry =
        table.name == std::string("coverage") || table.name == std::string("keyframes");
    const std::string sql = fmt::format(
        "INSERT INTO {} ({}{}) VALUES ({}{})", table.name, fmt::join(names, ", "),
        has_geometry ? ", geom" : "", fmt::join(std::vector<std::string>(names.size(), "?"), ", "),
        has_geometry ? ", ?" : "");
    while (row.Step()) {
      CopyRow(table, row, sql);
    }
  }

  void CopyRow(const Table& table, const db::Statement& row, const std::string& sql) {
    db::Statement copy = to_->Prepare(sql);
    std::vector<std::vector<uint8_t>> blobs;  // Statements do not copy them.
    const auto num_columns = static_cast<int>(table.columns.size());
    for (int i = 0; i < num_columns; ++i) {
      CopyValue(table.columns[i].type, row, i, &copy, &blobs);
    }
    if (std::vector<uint8_t> geometry = GeometryOf(table.name, row); !geometry.empty()) {
      blobs.push_back(std::move(geometry));
      copy.BindAt(num_columns + 1, db::Geometry{blobs.back()});
    }
    copy.Run();
  }

  static void CopyValue(Type type, const db::Statement& row, int column, db::Statement* copy,
                        std::vector<std::vector<uint8_t>>* blobs) {
    const int parameter = column + 1;
    if (row.IsNull(column)) {
      copy->BindAt(parameter, nullptr);
    } else if (type == Type::kInteger) {
      copy->BindAt(parameter, row.Int64(column));
    } else if (type == Type::kReal) {
      copy->BindAt(parameter, row.Double(column));
    } else if (type == Type::kText) {
      copy->BindAt(parameter, std::string_view(row.Text(column)));
    } else {
      blobs->push_back(row.Blob(column));
      copy->BindAt(parameter, std::span<const uint8_t>(blobs->back()));
    }
  }

  // The rows leave the counters behind the largest id of the latest version. Earlier versions,
  // pruned ones and plans may have larger ids.
  void CopyCounters() {
    for (const IdCounter counter :
         {IdCounter::kSession, IdCounter::kKeyframe, IdCounter::kCodebook}) {
      const int64_t num_missing = NextId(from_, counter) - NextId(to_, counter);
      TakeIds(to_, counter, std::max(int64_t{0}, num_missing));
    }
  }

  void CopyPayloads(const std::function<void(int64_t, int64_t)>& progress) {
    std::vector<std::pair<int64_t, std::string>> payloads;
    db::Statement row =
        from_->Prepare("SELECT payload_id, digest FROM cairn_payloads ORDER BY payload_id");
    while (row.Step()) {
      payloads.emplace_back(row.Int64(0), row.Text(1));
    }
    int64_t num_done = 0;
    for (const auto& [payload_id, digest] : payloads) {
      CopyPayload(payload_id, digest);
      if (progress) {
        progress(++num_done, std::ssize(payloads));
      }
    }
  }

  void CopyPayload(int64_t payload_id, const std::string& digest) {
    const auto bytes = from_->ReadBytes("cairn_payloads", "payload_id", payload_id);
    if (!bytes || ContentDigest(*bytes) != digest) {
      throw Error(ErrorCode::kMapDamaged,
                  fmt::format("{}: payload {} does not match its digest; run `cairn check` to find "
                              "all damage",
                              from_->name(), payload_id));
    }
    to_->Prepare("INSERT INTO cairn_payloads (payload_id, digest, bytes) VALUES (?, ?, ?)")
        .Bind(payload_id, digest, *bytes)
        .Run();
  }

  db::Connection* from_;
  db::Connection* to_;
};

}  // namespace

MapInfo CopyMap(const std::string& from, const std::string& to,
                const std::function<void(int64_t, int64_t)>& progress) {
  const std::unique_ptr<MapBackend> source = OpenBackend(from, OpenMode::kReadOnly);
  const std::unique_ptr<db::Connection> reader = source->Take({});
  const db::ReadTransaction reading(reader.get());
  MapInfo info;
  MapStore::CreateFilled(to, [&](MapStore* store) {
    const std::unique_ptr<MapBackend> target = OpenBackend(store->path(), OpenMode::kReadWrite);
    const std::unique_ptr<WriteTransaction> transaction = target->BeginUpdate();
    MapCopier(reader.get(), transaction->connection()).Run(progress);
    transaction->Commit();
    info = store->Snapshot().Info();
  });
  return info;
}

}  // namespace cairn
