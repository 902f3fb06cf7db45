#include "storage/map/internal/map_file.h"

#include <fcntl.h>
#include <sqlite3.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <optional>
#include <string_view>
#include <system_error>

#include "core/error.h"
#include "storage/database/sqlite/error.h"
#include "storage/database/sqlite/transaction.h"
#include "storage/inspection/register.h"
#include "storage/map/internal/head_writer.h"
#include "storage/map/internal/map_schema.h"
#include "storage/map/internal/sqlite_database.h"
#include "storage/map/internal/unfinished_file.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

// A reader waits this long for the exclusive lock that recovery of a crashed writer's log holds
// briefly.
constexpr int kReaderTimeoutMs = 5000;
// A writer waits this long for the write lock: a reader that finds the head of the log half written
// takes this lock for a moment, to read the head again. Most updates hold it for longer.
constexpr int kWriterTimeoutMs = 200;
constexpr size_t kSqliteHeaderSize = 100;
constexpr std::string_view kSqliteMagic("SQLite format 3\0", 16);
constexpr size_t kPageSizeOffset = 16;
constexpr size_t kApplicationIdOffset = 68;
constexpr std::string_view kGeoPackageId = "GPKG";

[[noreturn]] void Refuse(ErrorCode code, const std::string& path, const std::string& problem) {
  throw Error(code, path + ": " + problem);
}

// Guesses the kind of a file that is not an SQLite database.
std::string GuessKind(std::string_view head) {
  struct Magic {
    std::string_view bytes;
    const char* kind;
  };
  constexpr Magic kMagics[] = {
      {"\x89PNG", "a PNG image"},
      {"\xff\xd8\xff", "a JPEG image"},
      {"PK\x03\x04", "a ZIP archive"},
      {"\x1f\x8b", "a gzip file"},
      {"%PDF", "a PDF document"},
      {"\x7f"
       "ELF",
       "a program"},
      {"CTIL", "a single encoded tile"},
      {"CSHD", "a shard of a plan"},
      {"CRES", "a result of a plan"},
  };
  for (const Magic& magic : kMagics) {
    if (head.starts_with(magic.bytes)) {
      return magic.kind;
    }
  }
  const bool is_text = std::all_of(head.begin(), head.end(), [](unsigned char c) {
    return c >= 0x80 || std::isprint(c) != 0 || std::isspace(c) != 0;
  });
  return is_text ? "a text file" : "an unknown binary file";
}

// Returns true if the write-ahead log has content. Readers leave empty logs behind.
bool HasWriteAheadLog(const std::string& path) {
  std::error_code error;
  const auto size = fs::file_size(path + "-wal", error);
  return !error && size > 0;
}

void CheckFileType(const std::string& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (status.type() == fs::file_type::not_found) {
    Refuse(ErrorCode::kNotFound, path, "this map file does not exist; `cairn init` creates one");
  }
  if (status.type() == fs::file_type::directory) {
    Refuse(ErrorCode::kBadInput, path, "is a directory, not a Cairn map");
  }
  if (status.type() != fs::file_type::regular) {
    Refuse(error ? ErrorCode::kIo : ErrorCode::kBadInput, path,
           error ? "cannot be read: " + error.message() : "is not a regular file");
  }
}

// SQLite reads the file, because the process may have it open already: closing a descriptor of
// one's own would release the locks that the open connections hold. A writer in another process
// would then delete the write-ahead log that they use.
std::string ReadHead(const std::string& path) {
  try {
    const sqlite::Connection connection(path, sqlite::Access::kReadOnly, 0);
    sqlite3_file* file = nullptr;
    sqlite3_file_control(connection.handle(), nullptr, SQLITE_FCNTL_FILE_POINTER, &file);
    if (file != nullptr && file->pMethods != nullptr) {
      // SQLite takes a file of one byte for an empty one.
      std::string head(std::min<size_t>(fs::file_size(path), kSqliteHeaderSize), '\0');
      if (head.empty() ||
          file->pMethods->xRead(file, head.data(), static_cast<int>(head.size()), 0) == SQLITE_OK) {
        return head;
      }
    }
  } catch (const Error&) {
    // As below.
  } catch (const fs::filesystem_error&) {
    // As below.
  }
  Refuse(ErrorCode::kIo, path, "cannot be read; check its permissions");
}

[[noreturn]] void RefuseCutOff(const std::string& path, uint64_t size) {
  Refuse(ErrorCode::kMapDamaged, path, "is truncated after " + std::to_string(size) + " bytes");
}

// SQLite would read the missing part of a truncated last page as zeros, so truncation is detected
// here.
void CheckWholePages(const std::string& path, std::string_view head) {
  const auto byte = [head](size_t i) { return static_cast<unsigned char>(head[i]); };
  const uint64_t announced = byte(kPageSizeOffset) << 8 | byte(kPageSizeOffset + 1);
  const uint64_t page_size = announced == 1 ? 65536 : announced;
  std::error_code error;
  const uint64_t size = fs::file_size(path, error);
  if (error) {
    Refuse(ErrorCode::kIo, path, "cannot be read: " + error.message());
  }
  if (page_size == 0 || (size % page_size != 0 && !HasWriteAheadLog(path))) {
    RefuseCutOff(path, size);
  }
}

// Refuses files that cannot be maps before SQLite opens them.
void CheckFile(const std::string& path) {
  CheckFileType(path);
  const std::string head = ReadHead(path);
  if (head.empty()) {
    Refuse(ErrorCode::kBadInput, path, "is an empty file, not a Cairn map");
  }
  const size_t num_magic_bytes = std::min(head.size(), kSqliteMagic.size());
  if (head.compare(0, num_magic_bytes, kSqliteMagic.substr(0, num_magic_bytes)) != 0) {
    if (head.size() == kSqliteHeaderSize &&
        head.compare(kApplicationIdOffset, kGeoPackageId.size(), kGeoPackageId) == 0) {
      Refuse(ErrorCode::kMapDamaged, path, "the first bytes are damaged");
    }
    Refuse(ErrorCode::kBadInput, path, "is not a Cairn map; it seems to be " + GuessKind(head));
  }
  if (head.size() < kSqliteHeaderSize) {
    RefuseCutOff(path, head.size());
  }
  CheckWholePages(path, head);
}

bool HasTable(sqlite::Connection* connection, std::string_view name) {
  sqlite::Statement statement =
      connection->Prepare("SELECT count(*) FROM sqlite_schema WHERE type = 'table' AND name = ?");
  return statement.Bind(name).Step() && statement.Int64(0) > 0;
}

int64_t ApplicationId(sqlite::Connection* connection) {
  sqlite::Statement statement = connection->Prepare("PRAGMA application_id");
  statement.Step();
  return statement.Int64(0);
}

// Refuses SQLite databases that are not maps, and maps of a newer format.
void CheckIsMap(sqlite::Connection* connection) {
  constexpr int64_t kGeoPackageApplicationId = 0x47504b47;
  const std::string& path = connection->path();
  const int64_t application_id = ApplicationId(connection);
  if (!HasTable(connection, "cairn_map")) {
    std::string kind = "an SQLite database of another program";
    if (application_id == kGeoPackageApplicationId) {
      kind = "a GeoPackage of another program";
    } else if (HasTable(connection, "keypoints") && HasTable(connection, "descriptors")) {
      kind = "a COLMAP database; give it to `cairn ingest` as --database";
    }
    Refuse(ErrorCode::kBadInput, path, "is not a Cairn map; it seems to be " + kind);
  }
  if (application_id != kGeoPackageApplicationId) {
    Refuse(ErrorCode::kMapDamaged, path, "its application id is damaged");
  }
  sqlite::Statement statement =
      connection->Prepare("SELECT format_version, oldest_reader_version FROM cairn_map");
  if (!statement.Step()) {
    Refuse(ErrorCode::kMapDamaged, path, "the table cairn_map is empty");
  }
  if (statement.Int64(1) > kMapFormatVersion) {
    Refuse(ErrorCode::kConflict, path,
           "is a map of format " + std::to_string(statement.Int64(0)) +
               ", this program reads format " + std::to_string(kMapFormatVersion) +
               "; use a newer Cairn");
  }
  RequireMapSchema(connection);
}

std::unique_ptr<sqlite::Connection> Connect(const std::string& path, sqlite::Access access,
                                            int busy_timeout_ms) {
  auto connection = std::make_unique<sqlite::Connection>(path, access, busy_timeout_ms);
  if (const int result = inspection::RegisterGeometryFunctions(connection->handle());
      result != SQLITE_OK) {
    sqlite::ThrowError(connection->handle(), result, path, "register functions");
  }
  return connection;
}

std::unique_ptr<sqlite::Connection> OpenAndCheck(const std::string& path, sqlite::Access access) {
  std::unique_ptr<sqlite::Connection> connection = ReopenMapFile(path, access);
  CheckIsMap(connection.get());
  return connection;
}

void FillEmptyMap(const std::string& path) {
  SqliteDatabase database(Connect(path, sqlite::Access::kCreate, 0));
  sqlite::Connection* const connection = database.connection();
  // The page size must be set before anything is written. See
  // docs/decisions/0008-pages-of-16-kilobytes.md.
  connection->Execute("PRAGMA page_size = 16384");
  connection->Execute("PRAGMA journal_mode = WAL");
  sqlite::Transaction transaction(connection, sqlite::Transaction::Kind::kImmediate);
  CreateMapSchema(connection);
  AddFirstVersion(&database);
  transaction.Commit();
  // Closing the connection would also checkpoint, but would not report a full disk.
  connection->Execute("PRAGMA wal_checkpoint(TRUNCATE)");
}

// Moves the log into the file, so that the file can be renamed.
void CloseLog(const std::string& path) {
  Connect(path, sqlite::Access::kReadWrite, 0)->Execute("PRAGMA wal_checkpoint(TRUNCATE)");
  if (HasWriteAheadLog(path)) {
    Refuse(ErrorCode::kIo, path, "its write-ahead log cannot be moved into the file");
  }
}

}  // namespace

void CreateMapFile(const std::string& path, const std::function<void(const std::string&)>& fill) {
  UnfinishedFile file(path);
  try {
    FillEmptyMap(file.name());
    if (fill) {
      fill(file.name());
      CloseLog(file.name());
    }
    file.Finish();
  } catch (const Error& error) {
    // Name the requested file in the message, not the temporary one.
    std::string what = error.what();
    if (what.starts_with(file.name())) {
      what.replace(0, file.name().size(), path);
    }
    throw Error(error.code(), what);
  }
}

std::unique_ptr<sqlite::Connection> ReopenMapFile(const std::string& path, sqlite::Access access) {
  std::unique_ptr<sqlite::Connection> connection = Connect(path, access, kReaderTimeoutMs);
  connection->Execute("PRAGMA query_only = ON");
  return connection;
}

std::unique_ptr<sqlite::Connection> OpenMapFile(const std::string& path, sqlite::Access* access) {
  CheckFile(path);
  try {
    return OpenAndCheck(path, *access);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kIo || *access != sqlite::Access::kReadOnly ||
        HasWriteAheadLog(path)) {
      throw;
    }
  }
  *access = sqlite::Access::kImmutable;
  return OpenAndCheck(path, *access);
}

std::unique_ptr<sqlite::Connection> OpenMapFileForUpdate(const std::string& path) {
  std::unique_ptr<sqlite::Connection> connection =
      Connect(path, sqlite::Access::kReadWrite, kWriterTimeoutMs);
  connection->TrustSchema();  // The triggers of the layers write to R*Trees.
  // secure_delete = ON would overwrite freed pages, which costs as much as writing them. FAST
  // overwrites only where no extra page is written.
  connection->Execute("PRAGMA secure_delete = FAST");
  connection->Execute("PRAGMA journal_size_limit = 67108864");
  return connection;
}

}  // namespace cairn
