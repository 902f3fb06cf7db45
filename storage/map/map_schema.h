// The tables, views and triggers of a map: made for a new one, compared in one from outside;
// private to storage.
#ifndef CAIRN_STORAGE_MAP_MAP_SCHEMA_H_
#define CAIRN_STORAGE_MAP_MAP_SCHEMA_H_

#include <string>
#include <string_view>
#include <vector>

#include "storage/sqlite/connection.h"

namespace cairn {

// Runs schema.sql and views.sql.
void CreateMapSchema(sqlite::Connection* connection);

// Throws Error(kMapDamaged), naming the object, unless the file has everything that a new map has,
// made by the same SQL but for white space and comments, and otherwise only plain tables and their
// indices, which other programs may add and Cairn does not read (docs/formats/map_v1.md). So no
// view or trigger of a stranger ever runs.
void RequireMapSchema(sqlite::Connection* connection);

// A word, a quoted name or string with its quotes, or a single other character.
using SqlTokens = std::vector<std::string>;

// The tokens of a statement, without white space and comments. Quotes that do not end reach to the
// end of the text.
SqlTokens TokenizeSql(std::string_view sql);

}  // namespace cairn

#endif  // CAIRN_STORAGE_MAP_MAP_SCHEMA_H_
