#include "storage/map/internal/map_schema.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <utility>

#include "core/error.h"
#include "core/printable.h"
#include "sql/schema.h"
#include "storage/map/internal/accuracy_table.h"

namespace cairn {
namespace {

// A row of sqlite_schema.
struct SchemaObject {
  std::string type;
  std::string name;
  std::string table;
  SqlTokens sql;  // Empty for an index that a constraint created.
};

// The key is type and name.
using Schema = std::map<std::pair<std::string, std::string>, SchemaObject>;

bool IsWordCharacter(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '$' ||
         static_cast<unsigned char>(c) >= 0x80;
}

// Returns the number of bytes of the quoted name or string at the front. A doubled quote stands for
// one quote character.
size_t QuotedSize(std::string_view text) {
  const char end = text[0] == '[' ? ']' : text[0];
  size_t i = 1;
  while (i < text.size()) {
    if (text[i] != end) {
      ++i;
    } else if (end != ']' && i + 1 < text.size() && text[i + 1] == end) {
      i += 2;
    } else {
      return i + 1;
    }
  }
  return text.size();
}

// Returns the number of bytes of white space and comments at the front.
size_t BlankSize(std::string_view text) {
  size_t size = 0;
  while (size < text.size()) {
    const std::string_view rest = text.substr(size);
    size_t end = 0;
    if (std::isspace(static_cast<unsigned char>(rest[0])) != 0) {
      end = 1;
    } else if (rest.starts_with("--")) {
      end = std::min(rest.find('\n'), rest.size());
    } else if (rest.starts_with("/*")) {
      const size_t close = rest.find("*/", 2);
      end = close == std::string_view::npos ? rest.size() : close + 2;
    } else {
      break;
    }
    size += end;
  }
  return size;
}

std::string Lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

bool HasWord(const SqlTokens& tokens, const char* word) {
  return std::any_of(tokens.begin(), tokens.end(),
                     [word](const std::string& token) { return Lower(token) == word; });
}

// Returns the name without quotes, in lower case.
std::string PlainName(const std::string& token) {
  const bool is_quoted = token.size() >= 2 && !IsWordCharacter(token[0]);
  return Lower(is_quoted ? token.substr(1, token.size() - 2) : token);
}

Schema ReadSchema(sqlite::Connection* connection) {
  Schema schema;
  sqlite::Statement rows =
      connection->Prepare("SELECT type, name, tbl_name, coalesce(sql, '') FROM sqlite_schema");
  while (rows.Step()) {
    SchemaObject object{rows.Text(0), rows.Text(1), rows.Text(2), TokenizeSql(rows.Text(3))};
    schema.insert_or_assign({object.type, object.name}, std::move(object));
  }
  return schema;
}

const Schema& NewMapSchema() {
  static const Schema schema = [] {
    sqlite::Connection connection("a new map", sqlite::Access::kMemory, 0);
    CreateMapSchema(&connection);
    return ReadSchema(&connection);
  }();
  return schema;
}

bool IsTableOfMaps(const std::string& name) {
  return std::any_of(NewMapSchema().begin(), NewMapSchema().end(), [&](const auto& entry) {
    return entry.second.type == "table" && Lower(entry.second.name) == Lower(name);
  });
}

// Returns true if the table references a table of Cairn. Cairn deletes rows of its tables, and each
// deletion would search a table that references them.
bool RefersToCairn(const SqlTokens& sql) {
  for (size_t i = 0; i + 1 < sql.size(); ++i) {
    const std::string target = PlainName(sql[i + 1]);
    if (Lower(sql[i]) == "references" && IsTableOfMaps(target) && !target.starts_with("gpkg_")) {
      return true;
    }
  }
  return false;
}

// A check or a generated column is SQL that runs whenever its table is read or written.
std::string WhyNotPlainTable(const SchemaObject& table) {
  if (Lower(table.name).starts_with("cairn_")) {
    return "names that begin with cairn_ are reserved";
  }
  if (HasWord(table.sql, "virtual")) {
    return "it is a virtual table";
  }
  if (HasWord(table.sql, "check") || HasWord(table.sql, "as") || HasWord(table.sql, "generated")) {
    return "it has checks or generated columns";
  }
  if (RefersToCairn(table.sql)) {
    return "it references Cairn's tables";
  }
  return "";
}

// A plain index has only columns, no expressions.
std::string WhyNotPlainIndex(const SchemaObject& index) {
  if (IsTableOfMaps(index.table)) {
    return "it indexes one of the map's tables";
  }
  const auto is_plain = [](const std::string& token) {
    return IsWordCharacter(token[0]) || token == "," || token == ")" || token.size() > 1;
  };
  const auto num_others = std::count_if(index.sql.begin(), index.sql.end(),
                                        [&](const auto& token) { return !is_plain(token); });
  const bool is_of_columns = num_others == (index.sql.empty() ? 0 : 1);
  return is_of_columns && !HasWord(index.sql, "where")
             ? ""
             : "it indexes expressions or a part of the rows";
}

// Returns the reason why a map may not contain an object that a new map does not have; empty if the
// object is allowed.
std::string WhyNotAllowed(const SchemaObject& object) {
  if (object.type == "table") {
    return WhyNotPlainTable(object);
  }
  if (object.type == "index") {
    return WhyNotPlainIndex(object);
  }
  return "other programs may add only plain tables and indices";
}

[[noreturn]] void Refuse(const sqlite::Connection& connection, const SchemaObject& object,
                         const std::string& problem) {
  throw Error(ErrorCode::kMapDamaged, connection.path() + ": the " + Excerpt(object.type, 20) +
                                          " '" + Excerpt(object.name) + "' " + problem);
}

}  // namespace

void CreateMapSchema(sqlite::Connection* connection) {
  connection->Execute(std::string(sql::k_schema_sql));
  connection->Execute(std::string(sql::k_session_accuracy_sql));
  connection->Execute(std::string(sql::k_views_sql));
}

SqlTokens TokenizeSql(std::string_view sql) {
  SqlTokens tokens;
  while (true) {
    sql.remove_prefix(BlankSize(sql));
    if (sql.empty()) {
      return tokens;
    }
    size_t size = 1;
    if (IsWordCharacter(sql[0])) {
      const auto end = std::find_if_not(sql.begin(), sql.end(), IsWordCharacter);
      size = static_cast<size_t>(end - sql.begin());
    } else if (std::string_view("'\"`[").find(sql[0]) != std::string_view::npos) {
      size = QuotedSize(sql);
    }
    tokens.emplace_back(sql.substr(0, size));
    sql.remove_prefix(size);
  }
}

void RequireMapSchema(sqlite::Connection* connection) {
  const Schema schema = ReadSchema(connection);
  for (const auto& [key, expected] : NewMapSchema()) {
    const auto found = schema.find(key);
    if (found == schema.end()) {
      if (expected.name == accuracy_table::kName) {
        continue;
      }
      Refuse(*connection, expected, "is missing");
    }
    if (found->second.sql != expected.sql || found->second.table != expected.table) {
      Refuse(*connection, expected, "differs from the one in a new map");
    }
  }
  for (const auto& [key, object] : schema) {
    if (NewMapSchema().contains(key)) {
      continue;
    }
    if (const std::string problem = WhyNotAllowed(object); !problem.empty()) {
      Refuse(*connection, object, "does not belong in a map: " + problem);
    }
  }
}

}  // namespace cairn
