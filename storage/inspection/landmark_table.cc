// The virtual table `cairn_landmarks` has the landmarks of all tiles. `cairn_landmarks(:tile_id)`
// has the landmarks of one tile. Tiles are decoded as the rows are read. A landmark has one row for
// each tile that holds it.
#include <algorithm>
#include <cstdint>
#include <exception>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/geodesy.h"
#include "storage/inspection/register.h"
#include "storage/inspection/sqlite_api.h"
#include "storage/tile/tile.h"
#include "storage/tile/tile_codec.h"

namespace cairn::inspection {
namespace {

constexpr char kDeclaration[] =
    "CREATE TABLE cairn_landmarks (landmark_id INTEGER, tile TEXT, session_id INTEGER, "
    "x_m REAL, y_m REAL, z_m "
    "REAL, lat_deg REAL, lon_deg REAL, h_m REAL, sigma_m REAL, "
    "num_descriptors INTEGER, num_keyframes INTEGER, last_session_id INTEGER, "
    "num_sights INTEGER, num_chances INTEGER, tile_id INTEGER HIDDEN)";

enum Column {  // In the order of the declaration; x_m, y_m, z_m are in the tile frame.
  kLandmarkId,
  kTile,
  kSessionId,  // The first and the last session with a name that saw the landmark.
  kX,
  kY,
  kZ,
  kLat,
  kLon,
  kHeight,
  kSigma,
  kNumDescriptors,
  kNumKeyframes,
  kLastSessionId,
  kNumSights,
  kNumChances,
  kTileId,
};

enum Plan { kAllTiles = 0, kOneTile = 1 };

SessionId FirstSession(std::span<const HistoryEntry> history) {
  const auto first = std::find_if(history.begin(), history.end(), [](const auto& entry) {
    return entry.session_id != SessionId{} && entry.num_observations > 0;
  });
  return first == history.end() ? SessionId{} : first->session_id;
}

SessionId LastSession(std::span<const HistoryEntry> history) {
  const auto last = std::find_if(history.rbegin(), history.rend(),
                                 [](const auto& entry) { return entry.num_observations > 0; });
  return last == history.rend() ? SessionId{} : last->session_id;
}

// SQLite knows only the base classes. It stores pointers to them and passes the pointers back.
struct Table : sqlite3_vtab {
  sqlite3* db = nullptr;
};

class Cursor : public sqlite3_vtab_cursor {
 public:
  explicit Cursor(sqlite3* db) : sqlite3_vtab_cursor(), db_(db) {}
  ~Cursor() { sqlite3_finalize(payloads_); }
  Cursor(const Cursor&) = delete;
  Cursor& operator=(const Cursor&) = delete;

  // Start and Next return an SQLite result code.
  int Start(Plan plan, sqlite3_value* tile_id) {
    sqlite3_finalize(payloads_);
    payloads_ = nullptr;
    row_id_ = 0;
    const std::string sql = std::string(
                                "SELECT p.bytes FROM cairn_tiles AS t "
                                "JOIN cairn_payloads AS p ON p.payload_id = t.payload_id ") +
                            (plan == kOneTile ? "WHERE t.tile_id = ?" : "ORDER BY t.tile_id");
    int result = sqlite3_prepare_v2(db_, sql.c_str(), -1, &payloads_, nullptr);
    if (result == SQLITE_OK && plan == kOneTile) {
      result = sqlite3_bind_value(payloads_, 1, tile_id);
    }
    return result == SQLITE_OK ? NextTile() : result;
  }

  int Next() {
    ++row_id_;
    ++landmark_idx_;
    position_.reset();
    return landmark_idx_ < tile_.num_landmarks() ? SQLITE_OK : NextTile();
  }

  bool at_end() const { return at_end_; }
  int64_t row_id() const { return row_id_; }

  void PutColumn(int column, sqlite3_context* context) {
    const size_t i = landmark_idx_;
    switch (column) {
      case kLandmarkId:
        return sqlite3_result_int64(context, static_cast<int64_t>(Value(tile_.landmark_ids[i])));
      case kTile:
        return sqlite3_result_text(context, tile_name_.c_str(), -1, SQLITE_TRANSIENT);
      case kSessionId:
        return PutId(FirstSession(tile_.HistoryOf(i)), context);
      case kLastSessionId:
        return PutId(LastSession(tile_.HistoryOf(i)), context);
      case kNumSights:
        return sqlite3_result_int64(context, Sum(i, &HistoryEntry::num_observations));
      case kNumChances:
        return sqlite3_result_int64(context, Sum(i, &HistoryEntry::num_chances));
      case kX:
      case kY:
      case kZ:
        return sqlite3_result_double(context, tile_.x_in_tile[i][column - kX]);
      case kLat:
        return sqlite3_result_double(context, Position().lat_deg());
      case kLon:
        return sqlite3_result_double(context, Position().lon_deg());
      case kHeight:
        return sqlite3_result_double(context, Position().h_m);
      case kSigma:
        return sqlite3_result_double(context, SigmaFromCode(tile_.sigma_codes[i]));
      case kNumDescriptors:
        return sqlite3_result_int64(context,
                                    tile_.descriptor_begin[i + 1] - tile_.descriptor_begin[i]);
      case kNumKeyframes:
        return sqlite3_result_int64(context, num_keyframes_[i]);
      case kTileId:
        return sqlite3_result_int64(context, static_cast<int64_t>(tile_.id.value()));
    }
  }

 private:
  static void PutId(SessionId id, sqlite3_context* context) {
    return id == SessionId{} ? sqlite3_result_null(context)
                             : sqlite3_result_int64(context, Value(id));
  }

  int64_t Sum(size_t landmark_idx, uint8_t HistoryEntry::*count) const {
    int64_t sum = 0;
    for (const HistoryEntry& entry : tile_.HistoryOf(landmark_idx)) {
      sum += entry.*count;
    }
    return sum;
  }

  // Advances to the first landmark of the next tile that has any, or to the end.
  int NextTile() {
    while (true) {
      const int result = sqlite3_step(payloads_);
      at_end_ = result != SQLITE_ROW;
      if (at_end_) {
        return result == SQLITE_DONE ? SQLITE_OK : result;
      }
      const auto* bytes = static_cast<const uint8_t*>(sqlite3_column_blob(payloads_, 0));
      Decode({bytes, static_cast<size_t>(sqlite3_column_bytes(payloads_, 0))});
      if (tile_.num_landmarks() > 0) {
        return SQLITE_OK;
      }
    }
  }

  void Decode(std::span<const uint8_t> payload) {
    tile_ = DecodeTile(payload);
    tile_name_ = tile_.id.ToString();
    ecef_from_tile_ = EcefFromEnu(tile_.id.Anchor());
    num_keyframes_.assign(tile_.num_landmarks(), 0);
    for (const uint32_t landmark_idx : tile_.keyframe_landmarks) {
      ++num_keyframes_[landmark_idx];
    }
    landmark_idx_ = 0;
    position_.reset();
  }

  const Geodetic& Position() {
    if (!position_) {
      position_ = GeodeticFromEcef(ecef_from_tile_ * tile_.x_in_tile[landmark_idx_].cast<double>());
    }
    return *position_;
  }

  sqlite3* db_;
  sqlite3_stmt* payloads_ = nullptr;
  int64_t row_id_ = 0;
  bool at_end_ = true;
  Tile tile_;
  std::string tile_name_;
  Rigid3d ecef_from_tile_;
  std::vector<uint32_t> num_keyframes_;  // Per landmark.
  size_t landmark_idx_ = 0;
  std::optional<Geodetic> position_;  // Of the current landmark; computed on first use.
};

Cursor* CursorOf(sqlite3_vtab_cursor* cursor) { return static_cast<Cursor*>(cursor); }

// Runs an action that may throw. An exception becomes the table's error message.
template <typename Action>
int Guard(sqlite3_vtab* table, const Action& action) {
  try {
    return action();
  } catch (const std::exception& error) {
    sqlite3_free(table->zErrMsg);
    table->zErrMsg = sqlite3_mprintf("%s", error.what());
    return SQLITE_ERROR;
  }
}

int Connect(sqlite3* db, void* /*user_data*/, int /*num_arguments*/,
            const char* const* /*arguments*/, sqlite3_vtab** table, char** /*error*/) {
  const int result = sqlite3_declare_vtab(db, kDeclaration);
  if (result == SQLITE_OK) {
    auto* made = new (std::nothrow) Table();
    if (made == nullptr) {
      return SQLITE_NOMEM;
    }
    made->db = db;
    *table = made;
  }
  return result;
}

int Disconnect(sqlite3_vtab* table) {
  delete static_cast<Table*>(table);
  return SQLITE_OK;
}

int BestIndex(sqlite3_vtab* /*table*/, sqlite3_index_info* info) {
  constexpr double kCostOfATile = 1e5;
  constexpr double kCostOfAllTiles = 1e9;
  info->idxNum = kAllTiles;
  info->estimatedCost = kCostOfAllTiles;
  for (int i = 0; i < info->nConstraint; ++i) {
    const auto& constraint = info->aConstraint[i];
    if (constraint.iColumn == kTileId && constraint.op == SQLITE_INDEX_CONSTRAINT_EQ &&
        constraint.usable) {
      info->aConstraintUsage[i].argvIndex = 1;
      info->aConstraintUsage[i].omit = 1;
      info->idxNum = kOneTile;
      info->estimatedCost = kCostOfATile;
      break;
    }
  }
  return SQLITE_OK;
}

int Open(sqlite3_vtab* table, sqlite3_vtab_cursor** cursor) {
  return Guard(table, [&] {
    *cursor = new Cursor(static_cast<Table*>(table)->db);
    return SQLITE_OK;
  });
}

int Close(sqlite3_vtab_cursor* cursor) {
  delete CursorOf(cursor);
  return SQLITE_OK;
}

int Filter(sqlite3_vtab_cursor* cursor, int plan, const char* /*name*/, int /*num_values*/,
           sqlite3_value** values) {
  return Guard(cursor->pVtab, [&] {
    return CursorOf(cursor)->Start(static_cast<Plan>(plan), plan == kOneTile ? values[0] : nullptr);
  });
}

int Next(sqlite3_vtab_cursor* cursor) {
  return Guard(cursor->pVtab, [cursor] { return CursorOf(cursor)->Next(); });
}

int AtEnd(sqlite3_vtab_cursor* cursor) { return CursorOf(cursor)->at_end() ? 1 : 0; }

int PutColumn(sqlite3_vtab_cursor* cursor, sqlite3_context* context, int column) {
  return Guard(cursor->pVtab, [&] {
    CursorOf(cursor)->PutColumn(column, context);
    return SQLITE_OK;
  });
}

int RowId(sqlite3_vtab_cursor* cursor, sqlite3_int64* row_id) {
  *row_id = CursorOf(cursor)->row_id();
  return SQLITE_OK;
}

// A module without xCreate is eponymous: the table exists in every database under the module's
// name.
constexpr sqlite3_module MakeModule() {
  sqlite3_module module{};
  module.xConnect = &Connect;
  module.xDisconnect = &Disconnect;
  module.xBestIndex = &BestIndex;
  module.xOpen = &Open;
  module.xClose = &Close;
  module.xFilter = &Filter;
  module.xNext = &Next;
  module.xEof = &AtEnd;
  module.xColumn = &PutColumn;
  module.xRowid = &RowId;
  return module;
}

constexpr sqlite3_module kModule = MakeModule();

}  // namespace

int RegisterLandmarkTable(sqlite3* db) {
  return sqlite3_create_module_v2(db, "cairn_landmarks", &kModule, nullptr, nullptr);
}

}  // namespace cairn::inspection
