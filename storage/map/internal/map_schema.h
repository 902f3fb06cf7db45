// Creates the tables, views and triggers of a new map, and verifies them in an existing file.
// Private to storage.
#ifndef CAIRN_STORAGE_MAP_INTERNAL_MAP_SCHEMA_H_
#define CAIRN_STORAGE_MAP_INTERNAL_MAP_SCHEMA_H_

#include <string>
#include <string_view>
#include <vector>

#include "storage/database/sqlite/connection.h"

namespace cairn {

// Runs schema.sql, session_accuracy.sql and views.sql.
void CreateMapSchema(sqlite::Connection* connection);

// Throws Error(kMapDamaged), naming the object, unless the schema is that of a new map. The table
// session_accuracy may be missing, as in maps of earlier programs. SQL is compared without white
// space and comments. Other programs may add plain tables and indices on
// them, which Cairn does not read (docs/formats/map_v1.md). Views and triggers that Cairn did not
// create are refused, so none of them ever runs.
void RequireMapSchema(sqlite::Connection* connection);

// Each token is a word, a quoted name or string with its quotes, or any other single character.
using SqlTokens = std::vector<std::string>;

// Splits a statement into tokens and drops white space and comments. An unterminated quote extends
// to the end of the text.
SqlTokens TokenizeSql(std::string_view sql);

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_INTERNAL_MAP_SCHEMA_H_
