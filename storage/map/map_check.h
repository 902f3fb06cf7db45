// The thorough check of a map; private to storage.
#ifndef CAIRN_STORAGE_MAP_MAP_CHECK_H_
#define CAIRN_STORAGE_MAP_MAP_CHECK_H_

#include <cstdint>
#include <functional>
#include <map>
#include <string>

#include "storage/map/map_store.h"
#include "storage/sqlite/connection.h"

namespace cairn {

// See MapStore::Check. Damage that SQLite finds on the way ends the check and is reported.
CheckReport CheckMap(sqlite::Connection* connection,
                     const std::function<void(int64_t, int64_t)>& progress);

// The problems of a check. Of each kind the first few are kept and the others counted, so that a
// report stays short however large the map is.
class Findings {
 public:
  explicit Findings(CheckReport* report) : report_(report) {}

  // "tile 32N-...: its boxes ..." for where = "tile 32N-..." and problem = "its boxes ...".
  // Problems with the same words are of one kind.
  void Add(const std::string& where, const std::string& problem);
  void Add(const std::string& problem);
  // Says how many of each kind were not kept.
  void Finish();

 private:
  CheckReport* report_;
  std::map<std::string, int64_t> count_of_problem_;
  std::map<std::string, int64_t> num_left_out_;
};

// Parts of CheckMap. Every one takes time in proportion to the map's size. They throw
// Error(kMapDamaged) where they cannot go on.

// Pages of the file, indices and constraints: SQLite's own check. If it is false, the pages of a
// table may refer to each other in circles.
bool CheckPages(sqlite::Connection* connection, Findings* findings);

// What else SQL alone can tell: R*Trees, references, and rows that do not agree.
void CheckTables(sqlite::Connection* connection, Findings* findings);

// Geometries and spatial indices of the two layers, and every keyframe's pose, camera and place.
void CheckLayers(sqlite::Connection* connection, Findings* findings);

// Every codebook.
void CheckCodebooks(sqlite::Connection* connection, Findings* findings);

// A tile's payload, and what the tables say of it. `tile_id` is a row of the coverage, whatever its
// bits.
void CheckTile(sqlite::Connection* connection, int64_t tile_id, Findings* findings);

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_MAP_CHECK_H_
