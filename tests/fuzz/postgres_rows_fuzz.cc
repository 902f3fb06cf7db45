// Rows that a hostile PostgreSQL server sends, read as every type. The first byte of a value is its
// type, the second byte its length.
#include <algorithm>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "core/error.h"
#include "fuzz/fuzz_target.h"
#include "storage/database/postgres/result_row.h"

namespace cairn {
namespace {

constexpr Oid kTypes[] = {postgres::kBool,
                          postgres::kBytea,
                          postgres::kInt8,
                          postgres::kInt4,
                          postgres::kText,
                          postgres::kFloat8,
                          1700 /* numeric */};
constexpr int kNull = 255;  // As a length.

struct FuzzedValue {
  Oid type = 0;
  int size = 0;  // -1 for NULL.
  const char* bytes = nullptr;
};

std::vector<FuzzedValue> ValuesOf(std::string_view input) {
  std::vector<FuzzedValue> values;
  while (input.size() >= 2 && values.size() < 64) {
    const auto kind = static_cast<uint8_t>(input[0]);
    const int stated = static_cast<uint8_t>(input[1]);
    input.remove_prefix(2);
    const int size = stated == kNull ? -1 : std::min<int>(stated, static_cast<int>(input.size()));
    values.push_back({kTypes[kind % std::size(kTypes)], size, input.data()});
    input.remove_prefix(std::max(size, 0));
  }
  return values;
}

// The result that libpq makes of a row of these values.
std::unique_ptr<PGresult, decltype(&PQclear)> ResultOf(const std::vector<FuzzedValue>& values) {
  std::unique_ptr<PGresult, decltype(&PQclear)> result(
      PQmakeEmptyPGresult(nullptr, PGRES_TUPLES_OK), &PQclear);
  std::vector<PGresAttDesc> columns(values.size());
  std::string name = "column";
  for (size_t i = 0; i < values.size(); ++i) {
    columns[i] = {name.data(), 0, 0, /*format=*/1, values[i].type, values[i].size, -1};
  }
  CAIRN_CHECK(PQsetResultAttrs(result.get(), static_cast<int>(columns.size()), columns.data()) != 0,
              "cannot make a result");
  for (size_t i = 0; i < values.size(); ++i) {
    // libpq copies the value.
    CAIRN_CHECK(PQsetvalue(result.get(), 0, static_cast<int>(i), const_cast<char*>(values[i].bytes),
                           values[i].size) != 0,
                "cannot set a value");
  }
  return result;
}

template <typename Read>
void ReadOrRefuse(const Read& read) {
  try {
    read();
  } catch (const Error& error) {
    CAIRN_CHECK(error.code() == ErrorCode::kMapDamaged, error.what());
  }
}

}  // namespace
}  // namespace cairn

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace cairn;
  const std::vector<FuzzedValue> values = ValuesOf(cairn::testing::AsText(data, size));
  const auto result = ResultOf(values);
  const std::string name = "postgresql://db/city";
  const postgres::ResultRow row(result.get(), 0, &name);
  // A statement may have fewer columns than its reader expects.
  for (int column = 0; column <= static_cast<int>(values.size()); ++column) {
    row.IsNull(column);
    ReadOrRefuse([&] { row.Int64(column); });
    ReadOrRefuse([&] { row.Double(column); });
    ReadOrRefuse([&] { CAIRN_CHECK(row.Text(column).size() <= size, "more text than was sent"); });
    ReadOrRefuse(
        [&] { CAIRN_CHECK(row.Bytes(column).size() <= size, "more bytes than were sent"); });
  }
  return 0;
}
