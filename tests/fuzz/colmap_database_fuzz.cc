// A row of a COLMAP database. The first five bytes are the rows and columns of the keypoints, the
// rows and columns of the descriptors, and the end of the keypoints' blob (in 256ths of the rest).
#include <sqlite3.h>

#include <string>

#include "core/error.h"
#include "fuzz/fuzz_file.h"
#include "fuzz/fuzz_target.h"
#include "ingest/colmap/colmap_database.h"

namespace cairn {
namespace {

// One connection, one database, whose two rows are replaced.
class Database {
 public:
  Database() : path_(testing::FuzzFolder().File("database.db")) {
    CAIRN_CHECK(sqlite3_open(path_.c_str(), &connection_) == SQLITE_OK, "cannot make a database");
    Execute("PRAGMA journal_mode = MEMORY");
    Execute("PRAGMA synchronous = OFF");
    Execute("CREATE TABLE images (image_id INTEGER PRIMARY KEY, name TEXT, camera_id INTEGER)");
    Execute("INSERT INTO images VALUES (1, 'a', 1)");
    for (const char* table : {"keypoints", "descriptors"}) {
      Execute(std::string("CREATE TABLE ") + table +
              " (image_id INTEGER PRIMARY KEY, rows INTEGER, cols INTEGER, data BLOB)");
    }
  }
  Database(const Database&) = delete;
  ~Database() { sqlite3_close(connection_); }

  const std::string& path() const { return path_; }

  void Put(const std::string& table, int rows, int cols, std::span<const uint8_t> blob) {
    sqlite3_stmt* statement = nullptr;
    const std::string sql = "INSERT OR REPLACE INTO " + table + " VALUES (1, ?, ?, ?)";
    sqlite3_prepare_v2(connection_, sql.c_str(), -1, &statement, nullptr);
    sqlite3_bind_int(statement, 1, rows);
    sqlite3_bind_int(statement, 2, cols);
    sqlite3_bind_blob(statement, 3, blob.data(), static_cast<int>(blob.size()), SQLITE_TRANSIENT);
    CAIRN_CHECK(sqlite3_step(statement) == SQLITE_DONE, "cannot write a row");
    sqlite3_finalize(statement);
  }

 private:
  void Execute(const std::string& sql) {
    CAIRN_CHECK(sqlite3_exec(connection_, sql.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK,
                sql.c_str());
  }

  std::string path_;
  sqlite3* connection_ = nullptr;
};

}  // namespace
}  // namespace cairn

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace cairn;
  constexpr size_t kHeaderSize = 5;
  if (size < kHeaderSize) {
    return 0;
  }
  static Database database;
  const std::span<const uint8_t> rest(data + kHeaderSize, size - kHeaderSize);
  const size_t end = rest.size() * data[4] / 256;
  database.Put("keypoints", static_cast<int8_t>(data[0]), data[1], rest.first(end));
  database.Put("descriptors", static_cast<int8_t>(data[2]), data[3], rest.subspan(end));
  try {
    const PackedFeatures features = ColmapDatabase(database.path()).ReadFeatures("a");
    CAIRN_CHECK(features.descriptors.rows() == static_cast<int64_t>(features.keypoints.size()),
                "keypoints without descriptors");
  } catch (const Error& error) {
    CAIRN_CHECK(error.code() == ErrorCode::kBadInput, error.what());
  }
  return 0;
}
