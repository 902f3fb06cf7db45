// A map file whose rows, or whose pages, somebody has changed. Every reader ends with the
// documented errors. An input is a list of changes:
//   0..1  which column of which table, or which page
//   2     0 to 127: the type of a value; 128 to 255: bytes of the page
//   3     the row
//   4..5  the offset in the page
//   6     number of bytes that follow
//   7..   the bytes
#include <sqlite3.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "fuzz/fuzz_file.h"
#include "fuzz/fuzz_target.h"
#include "storage/map/map_store.h"
#include "support/street_map.h"

namespace cairn {
namespace {

struct Change {
  uint16_t place = 0;
  bool is_page = false;
  uint8_t kind = 0;
  uint8_t row = 0;
  uint16_t offset = 0;
  std::string_view bytes;
};

std::vector<Change> ChangesOf(std::string_view input) {
  constexpr size_t kHeaderSize = 7, kMaxChanges = 16;
  std::vector<Change> changes;
  while (input.size() > kHeaderSize && changes.size() < kMaxChanges) {
    const auto byte = [&](size_t i) { return static_cast<uint8_t>(input[i]); };
    const size_t num_bytes = std::min<size_t>(byte(6), input.size() - kHeaderSize);
    changes.push_back({static_cast<uint16_t>(byte(0) << 8 | byte(1)), byte(2) >= 128,
                       static_cast<uint8_t>(byte(2) & 127), byte(3),
                       static_cast<uint16_t>(byte(4) << 8 | byte(5)),
                       input.substr(kHeaderSize, num_bytes)});
    input.remove_prefix(kHeaderSize + num_bytes);
  }
  return changes;
}

// A sound map, which each input changes in a copy.
class HostileMap {
 public:
  HostileMap() : path_(cairn::testing::FuzzFolder().File("map.gpkg")) {
    const std::string whole =
        cairn::testing::MakeStreetMap(cairn::testing::FuzzFolder().File("whole.gpkg"));
    {
      MapStore store = MapStore::Open(whole, OpenMode::kReadWrite);
      MapUpdate update = store.BeginUpdate();
      update.RemoveTile(store.Snapshot().AllTiles(1).front().tile_id);
      update.Publish();
    }
    std::ifstream file(whole, std::ios::binary);
    sound_.assign(std::istreambuf_iterator<char>(file), {});
    Restore({});
    OpenDatabase([this](sqlite3* db) { ListColumns(db); });
  }

  const std::string& path() const { return path_; }

  void Apply(const std::vector<Change>& changes) {
    Restore(changes);
    OpenDatabase([&](sqlite3* db) {
      for (const Change& change : changes) {
        if (!change.is_page) {
          SetValue(db, change);
        }
      }
    });
  }

 private:
  static constexpr size_t kPageBytes = 4096;

  // Writes the sound map with the changed pages.
  void Restore(const std::vector<Change>& changes) {
    for (const char* suffix : {"-wal", "-shm", "-journal"}) {
      std::remove((path_ + suffix).c_str());
    }
    std::string bytes = sound_;
    for (const Change& change : changes) {
      const size_t begin =
          change.place % (bytes.size() / kPageBytes) * kPageBytes + change.offset % kPageBytes;
      const size_t num_bytes = std::min(change.bytes.size(), bytes.size() - begin);
      if (change.is_page) {
        std::memcpy(bytes.data() + begin, change.bytes.data(), num_bytes);
      }
    }
    std::ofstream(path_, std::ios::binary | std::ios::trunc) << bytes;
  }

  template <typename Use>
  void OpenDatabase(const Use& use) {
    sqlite3* db = nullptr;
    if (sqlite3_open(path_.c_str(), &db) == SQLITE_OK) {
      sqlite3_exec(db,
                   "PRAGMA ignore_check_constraints = ON; PRAGMA synchronous = OFF; PRAGMA "
                   "recursive_triggers = OFF",
                   nullptr, nullptr, nullptr);
      use(db);
    }
    sqlite3_close(db);
  }

  void ListColumns(sqlite3* db) {
    sqlite3_stmt* rows = nullptr;
    sqlite3_prepare_v2(db,
                       "SELECT m.name, c.name FROM sqlite_master m, pragma_table_info(m.name) c "
                       "WHERE m.type = 'table' AND m.name NOT LIKE 'sqlite_%' ORDER BY 1, 2",
                       -1, &rows, nullptr);
    while (sqlite3_step(rows) == SQLITE_ROW) {
      const auto text = [&](int i) {
        return std::string(reinterpret_cast<const char*>(sqlite3_column_text(rows, i)));
      };
      columns_.emplace_back(text(0), text(1));
    }
    sqlite3_finalize(rows);
    CAIRN_CHECK(!columns_.empty(), "no tables");
  }

  // Triggers that need functions of GeoPackage refuse some changes, as they would elsewhere.
  void SetValue(sqlite3* db, const Change& change) {
    const auto& [table, column] = columns_[change.place % columns_.size()];
    const std::string sql = "UPDATE \"" + table + "\" SET \"" + column +
                            "\" = ? WHERE rowid = (SELECT rowid FROM \"" + table +
                            "\" LIMIT 1 OFFSET " + std::to_string(change.row % 8) + ")";
    sqlite3_stmt* statement = nullptr;
    if (sqlite3_prepare_v2(db, sql.c_str(), -1, &statement, nullptr) == SQLITE_OK) {
      Bind(statement, change);
      sqlite3_step(statement);
    }
    sqlite3_finalize(statement);
  }

  static void Bind(sqlite3_stmt* statement, const Change& change) {
    const auto size = static_cast<int>(change.bytes.size());
    int64_t number = 0;
    std::memcpy(&number, change.bytes.data(), std::min<size_t>(sizeof(number), size));
    double real = 0.0;
    std::memcpy(&real, &number, sizeof(real));
    switch (change.kind % 5) {
      case 0:
        sqlite3_bind_int64(statement, 1, number);
        break;
      case 1:
        sqlite3_bind_double(statement, 1, real);
        break;
      case 2:
        sqlite3_bind_text(statement, 1, change.bytes.data(), size, SQLITE_TRANSIENT);
        break;
      case 3:
        sqlite3_bind_blob(statement, 1, change.bytes.data(), size, SQLITE_TRANSIENT);
        break;
      default:
        sqlite3_bind_null(statement, 1);
    }
  }

  std::string path_;
  std::string sound_;
  std::vector<std::pair<std::string, std::string>> columns_;
};

template <typename Action>
void EndOrRefuse(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    CAIRN_CHECK(error.code() != ErrorCode::kInternal, error.what());
  }
}

void ReadAll(const MapStore& store) {
  const MapSnapshot snapshot = store.Snapshot();
  EndOrRefuse([&] { snapshot.Info(); });
  EndOrRefuse([&] { snapshot.Versions(10); });
  EndOrRefuse([&] { snapshot.Diff(MapVersion(2), snapshot.version()); });
  EndOrRefuse([&] { snapshot.CurrentCodebook(); });
  EndOrRefuse([&] {
    snapshot.FindTilePage({.box = GeoBox{0.8, 0.1, 0.9, 0.2}, .after = {}, .limit = 10});
  });
  EndOrRefuse([&] {
    for (const TileRecord& tile : snapshot.AllTiles(10)) {
      EndOrRefuse([&] { snapshot.LoadPayload(tile.payload_id); });
      EndOrRefuse([&] { snapshot.KeyframesOfTile(tile.tile_id); });
      EndOrRefuse([&] { snapshot.LoadCodebook(tile.codebook_id); });
      EndOrRefuse([&] { snapshot.FindTiles(tile.tile_id.Bounds()); });
    }
  });
  EndOrRefuse([&] {
    for (const SessionRecord& session : snapshot.Sessions()) {
      EndOrRefuse([&] { snapshot.TilesOfSession(session.id); });
      EndOrRefuse([&] { snapshot.KeyframesOfSession(session.id); });
    }
  });
  EndOrRefuse([&] { store.Check({}); });
}

void Update(MapStore* store) {
  MapUpdate update = store->BeginUpdate();
  for (const TileRecord& tile : store->Snapshot().AllTiles(2)) {
    update.RemoveTile(tile.tile_id);
  }
  update.Publish();
}

}  // namespace
}  // namespace cairn

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace cairn;
  static HostileMap map;
  map.Apply(ChangesOf(cairn::testing::AsText(data, size)));
  EndOrRefuse([] {
    MapStore store = MapStore::Open(map.path(), OpenMode::kReadWrite);
    ReadAll(store);
    Update(&store);
  });
  return 0;
}
