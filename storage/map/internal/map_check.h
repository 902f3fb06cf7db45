// The thorough check of a map. Private to storage.
#ifndef CAIRN_STORAGE_MAP_INTERNAL_MAP_CHECK_H_
#define CAIRN_STORAGE_MAP_INTERNAL_MAP_CHECK_H_

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>

#include "core/error.h"
#include "storage/database/connection.h"
#include "storage/map/internal/version_queries.h"
#include "storage/map/map_store.h"

namespace cairn {

// Implements MapStore::Check. A file gets all parts below; a PostgreSQL database gets the parts
// that do not depend on SQLite. If SQLite itself finds damaged pages, the tables as a whole are not
// checked, but codebooks and tiles are.
CheckReport CheckMap(db::Connection* connection,
                     const std::function<void(int64_t, int64_t)>& progress);

// Collects the problems that a check finds. Keeps the first few problems of each kind and counts
// the others, so the report of a large map stays short.
class Findings {
 public:
  explicit Findings(CheckReport* report) : report_(report) {}

  // Adds "tile 32N-...: its boxes ..." for where = "tile 32N-..." and problem = "its boxes ...".
  // Two problems are of the same kind if `problem` is the same text.
  void Add(const std::string& where, const std::string& problem);
  void Add(const std::string& problem);
  // Runs `check`. If `check` throws because a value cannot be read, adds that error at `where`.
  template <typename Check>
  void Run(const std::string& where, const Check& check) {
    try {
      check();
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kMapDamaged && error.code() != ErrorCode::kBadInput) {
        throw;
      }
      Add(where, error.what());
    }
  }
  // Adds a line for each kind of problem that has more occurrences than were kept.
  void Finish();

 private:
  CheckReport* report_;
  std::map<std::string, int64_t> count_of_problem_;
  std::map<std::string, int64_t> num_left_out_;
};

// Returns true if the boxes differ by at most 6 mm on each side. Machines round differently.
bool SameBounds(const GeoBox& a, const GeoBox& b);

// A query that counts invalid rows, and the message that follows their number. With `counts_rows`
// false, the query says whether a table is invalid (not 0), and the message stands alone.
struct Rule {
  const char* sql;
  const char* problem;
  bool counts_rows = true;
};

void CheckRules(db::Connection* connection, std::span<const Rule> rules, Findings* findings);

// The parts of CheckMap. Each takes time in proportion to the map's size, and throws
// Error(kMapDamaged) if damage keeps the check from going on.

// Runs SQLite's own check of the file's pages, indices and constraints. If it returns false, do not
// scan whole tables: their pages may form cycles.
bool CheckPages(db::Connection* connection, Findings* findings);

// Checks everything else that SQL alone can check: the R*Trees, the references, and rows that
// contradict each other.
void CheckTables(db::Connection* connection, Findings* findings);

// Checks what SQL alone can check of a PostgreSQL database, which keeps its indices, references and
// types itself: rows that contradict each other.
void CheckPostgresTables(db::Connection* connection, Findings* findings);

// Checks the geometries of the two layers, their spatial indices in a file, and every keyframe's
// pose, camera and tile.
void CheckLayers(db::Connection* connection, Findings* findings);

// Decodes every codebook.
void CheckCodebooks(db::Connection* connection, Findings* findings);

// Checks that version numbers have no gaps, that the rows of the past fit the versions, and that
// the totals of each version match its content. Decodes every keyframe of the past.
void CheckVersions(db::Connection* connection, Findings* findings);

// Checks a tile's payload and compares it with the tables. `tile_id` is the key of a row of the
// coverage layer; it need not be a valid tile id.
void CheckTile(db::Connection* connection, int64_t tile_id, Findings* findings);
// Checks a tile of the past in the same way.
void CheckPastTile(db::Connection* connection, const queries::PastTile& tile, Findings* findings);

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_INTERNAL_MAP_CHECK_H_
