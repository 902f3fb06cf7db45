// Tests of maps on a PostgreSQL server: what differs from a file. Tests of what is the same are in
// map/, and run on both.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/error.h"
#include "storage/database/postgres/address.h"
#include "storage/map/copy_map.h"
#include "storage/map/map_store.h"
#include "storage/tile/tile_codec.h"
#include "support/cut_wire.h"
#include "support/map_builder.h"
#include "support/places.h"
#include "support/postgres_cluster.h"
#include "support/raw_sql.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;
using testing::ContentOf;
using ::testing::ElementsAre;
using testing::ErrorCodeOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using testing::PostgresCluster;
using testing::PutPlace;
using testing::RowsOf;

// The text of the Error that `action` throws.
template <typename Action>
std::string MessageOf(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(PostgresAddress, OfSeveralHostsHasSettingsForEach) {
  const auto hosts = postgres::ParseAddress("postgresql://u@a:1,b:2/m?sslmode=require");
  ASSERT_EQ(hosts.size(), 2u);
  EXPECT_THAT(hosts[1], ::testing::Contains(std::pair<std::string, std::string>("host", "b")));
  EXPECT_THAT(hosts[1], ::testing::Contains(std::pair<std::string, std::string>("port", "2")));
  EXPECT_THAT(hosts[1],
              ::testing::Contains(std::pair<std::string, std::string>("sslmode", "require")));
}

TEST(PostgresAddress, WithAPasswordIsRefusedAndNotRepeated) {
  for (const char* url : {"postgresql://u:secret@h/m", "postgresql://u@h/m?password=secret",
                          "postgresql://u:secret/m", "postgresql://u@h:secret:1/m",
                          "postgresql://[u:secret@h/m", "postgresql://u@h/m?secret"}) {
    EXPECT_EQ(ErrorCodeOf([&] { postgres::ParseAddress(url); }), ErrorCode::kInvalidArgument);
    EXPECT_THAT(MessageOf([&] { postgres::ParseAddress(url); }), Not(HasSubstr("secret"))) << url;
  }
}

// A map with one place, in a cluster that the test may break.
class PostgresTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (const std::string reason = PostgresCluster::WhyNot(); !reason.empty()) {
      GTEST_SKIP() << reason;
    }
    cluster_.emplace();
    url_ = cluster_->CreateDatabase("city");
    Put(0);
  }

  void Put(int place, int num_landmarks = 20) {
    MapStore store = exists_ ? MapStore::Open(url_, OpenMode::kReadWrite) : MapStore::Create(url_);
    exists_ = true;
    MapUpdate update = store.BeginUpdate();
    PutPlace(place, 1, &update, num_landmarks);
    update.Publish();
  }

  // Waits for what a thread does within seconds.
  template <typename Condition>
  static bool ComesTrue(const Condition& condition) {
    const Clock::time_point end = Clock::now() + std::chrono::seconds(20);
    while (!condition()) {
      if (Clock::now() > end) {
        return false;
      }
      std::this_thread::yield();
    }
    return true;
  }

  GeoBox Box() const { return BoxAround(testing::PositionOfPlace(0), 50.0); }

  std::optional<PostgresCluster> cluster_;
  std::string url_;
  bool exists_ = false;
};

TEST_F(PostgresTest, AServingStoreSeesNewVersionsWithoutReading) {
  const MapStore store = MapStore::Open(url_, OpenMode::kServing);
  EXPECT_EQ(store.Snapshot().version(), MapVersion(2));
  Put(1);
  EXPECT_TRUE(ComesTrue([&] { return store.Snapshot().version() == MapVersion(3); }));
  EXPECT_EQ(store.Stats().num_calls, 0);
}

// A publisher says so at once (NOTIFY): ten versions are seen in less time than ten polls take.
TEST_F(PostgresTest, AServingStoreDoesNotWaitForThePoll) {
  const MapStore store = MapStore::Open(url_, OpenMode::kServing);
  std::chrono::nanoseconds waited{};
  for (int i = 1; i <= 10; ++i) {
    Put(i);
    const Clock::time_point published = Clock::now();
    ASSERT_TRUE(ComesTrue([&] { return store.Snapshot().version() == MapVersion(2 + i); }));
    waited += Clock::now() - published;
  }
  EXPECT_LT(waited, std::chrono::milliseconds(2500));  // Polls would take 5 s on average.
}

// A standby that lacked the newest version has become the primary, and gives the number of that
// version to another one.
TEST_F(PostgresTest, AVersionThatTheServerHasLostIsForgotten) {
  const std::string replica = cluster_->CreateDatabase("replica");
  const testing::TempDir dir;
  CopyMap(url_, dir.File("map.gpkg"), {});
  CopyMap(dir.File("map.gpkg"), replica, {});
  Put(1);
  const MapStore store = MapStore::Open(url_, OpenMode::kServing);
  const GeoBox lost = BoxAround(testing::PositionOfPlace(1), 50.0);
  const GeoBox other = BoxAround(testing::PositionOfPlace(2), 50.0);
  EXPECT_EQ(store.Snapshot().FindTiles(lost).size(), 1u);
  EXPECT_THAT(store.Snapshot().FindTiles(other), IsEmpty());
  const MapSnapshot pinned = store.Snapshot();

  cluster_->Execute("postgres", "ALTER DATABASE city ALLOW_CONNECTIONS false");
  cluster_->Execute(
      "postgres", "SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE datname = 'city'");
  EXPECT_TRUE(ComesTrue([&] {
    try {
      cluster_->Execute("postgres", "ALTER DATABASE city RENAME TO lost");
      return true;
    } catch (const Error&) {  // A connection has not ended yet.
      return false;
    }
  }));
  cluster_->Execute("postgres", "ALTER DATABASE replica RENAME TO city");
  EXPECT_TRUE(ComesTrue([&] { return store.Snapshot().version() == MapVersion(2); }));
  EXPECT_EQ(ErrorCodeOf([&] { pinned.AllTiles(9); }), ErrorCode::kUnavailable);
  Put(2);
  EXPECT_TRUE(ComesTrue([&] { return store.Snapshot().version() == MapVersion(3); }));
  EXPECT_THAT(store.Snapshot().FindTiles(lost), IsEmpty());
  EXPECT_EQ(store.Snapshot().FindTiles(other).size(), 1u);
}

TEST_F(PostgresTest, AKilledServerLeavesCachedTilesWhichAreStale) {
  const MapStore store = MapStore::Open(url_, OpenMode::kServing);
  EXPECT_EQ(store.Snapshot().FindTiles(Box()).size(), 1u);
  cluster_->Kill();
  EXPECT_TRUE(ComesTrue([&] { return store.Snapshot().is_stale(); }));
  EXPECT_EQ(store.Snapshot().FindTiles(Box()).size(), 1u);
  EXPECT_EQ(ErrorCodeOf([&] { store.Snapshot().AllTiles(1); }), ErrorCode::kUnavailable);
  cluster_->Start();
  EXPECT_TRUE(ComesTrue([&] { return !store.Snapshot().is_stale(); }));
  EXPECT_EQ(store.Snapshot().AllTiles(1).size(), 1u);
}

TEST_F(PostgresTest, AFrozenServerIsGivenUpAtTheDeadline) {
  const MapStore store = MapStore::Open(url_, OpenMode::kServing);
  EXPECT_EQ(store.Snapshot().AllTiles(1).size(), 1u);
  cluster_->Freeze();
  const Clock::time_point begin = Clock::now();
  EXPECT_EQ(ErrorCodeOf([&] { store.Snapshot(begin + milliseconds(100)).AllTiles(1); }),
            ErrorCode::kUnavailable);
  EXPECT_GE(Clock::now() - begin, milliseconds(100));
  EXPECT_LT(Clock::now() - begin, std::chrono::seconds(2));  // The bar of a server is 150 ms.
  EXPECT_TRUE(ComesTrue([&] { return store.Snapshot().is_stale(); }));
  cluster_->Thaw();
  EXPECT_TRUE(ComesTrue([&] { return !store.Snapshot().is_stale(); }));
  EXPECT_EQ(store.Snapshot().AllTiles(1).size(), 1u);
}

// What has no deadline, such as a page for operators, does not hold a worker for long.
TEST_F(PostgresTest, AFrozenServerIsGivenUpWithoutADeadlineToo) {
  const MapStore store = MapStore::Open(url_, OpenMode::kServing);
  EXPECT_EQ(store.Snapshot().AllTiles(1).size(), 1u);
  cluster_->Freeze();
  EXPECT_EQ(ErrorCodeOf([&] { store.Snapshot().AllTiles(1); }), ErrorCode::kUnavailable);
  cluster_->Thaw();
  EXPECT_TRUE(ComesTrue([&] { return !store.Snapshot().is_stale(); }));
}

TEST_F(PostgresTest, AnAnswerCutOffHalfwayThroughAPayloadIsGivenUp) {
  constexpr int kNumLandmarks = 20'000;
  Put(0, kNumLandmarks);
  testing::CutWire wire(cluster_->folder());
  const MapStore store = MapStore::Open("postgresql:///city?host=" + wire.folder() + "&user=cairn",
                                        OpenMode::kServing);
  const std::vector<TileRecord> tiles = store.Snapshot().FindTiles(Box());
  ASSERT_EQ(tiles.size(), 1u);
  ASSERT_GT(tiles[0].num_bytes, 500'000);
  const auto load = [&](Clock::time_point deadline) {
    return store.Snapshot(deadline).LoadPayload(tiles[0].payload_id);
  };
  for (const auto kind : {testing::CutWire::Kind::kSilent, testing::CutWire::Kind::kClosed}) {
    wire.CutAfter(tiles[0].num_bytes / 2, kind);
    const Clock::time_point begin = Clock::now();
    EXPECT_EQ(ErrorCodeOf([&] { load(begin + milliseconds(300)); }), ErrorCode::kUnavailable);
    EXPECT_LT(Clock::now() - begin, std::chrono::seconds(3));
    EXPECT_EQ(store.Snapshot().FindTiles(Box()).size(), 1u);  // Cached.
    wire.Mend();
    LargeVector<uint8_t> payload;
    EXPECT_TRUE(ComesTrue([&] {
      const auto reload = [&] { payload = load(Clock::now() + std::chrono::seconds(5)); };
      return ErrorCodeOf(reload) != ErrorCode::kUnavailable;
    }));
    EXPECT_EQ(std::ssize(payload), tiles[0].num_bytes);
    EXPECT_EQ(DecodeTile(payload).num_landmarks(), size_t{kNumLandmarks});
  }
}

TEST_F(PostgresTest, AMapGoesToAFileAndBackToTheByte) {
  const testing::TempDir dir;
  Put(1);
  const std::string file = dir.File("city.gpkg");
  const std::string back = cluster_->CreateDatabase("back");
  CopyMap(url_, file, {});
  CopyMap(file, back, {});
  EXPECT_EQ(ContentOf(back), ContentOf(url_));
  const char* const digests = "SELECT payload_id, digest FROM cairn_payloads ORDER BY payload_id";
  EXPECT_EQ(RowsOf(file, digests), RowsOf(url_, digests));
  for (const std::string& map : {file, back}) {
    MapStore store = MapStore::Open(map, OpenMode::kReadWrite);
    EXPECT_EQ(store.Snapshot().Versions(9).size(), 3u);
    EXPECT_THAT(store.Check({}).problems, IsEmpty());
    MapUpdate update = store.BeginUpdate();  // Ids go on.
    PutPlace(2, 3, &update);
    update.Publish();
    EXPECT_THAT(store.Check({}).problems, IsEmpty());
  }
  EXPECT_EQ(ErrorCodeOf([&] { CopyMap(file, url_, {}); }), ErrorCode::kConflict);
}

TEST_F(PostgresTest, ADamagedPayloadIsNotCopied) {
  const testing::TempDir dir;
  testing::ExecuteRaw(url_, "UPDATE cairn_payloads SET bytes = set_byte(bytes, 9, 77)");
  EXPECT_EQ(ErrorCodeOf([&] { CopyMap(url_, dir.File("a.gpkg"), {}); }), ErrorCode::kMapDamaged);
  EXPECT_FALSE(std::filesystem::exists(dir.File("a.gpkg")));
}

TEST_F(PostgresTest, OneFlippedByteDamagesOneTile) {
  Put(1);
  testing::ExecuteRaw(url_,
                      "UPDATE cairn_payloads SET bytes = set_byte(bytes, 99, "
                      "255 - get_byte(bytes, 99)) WHERE payload_id = 1");
  const CheckReport report = MapStore::Open(url_, OpenMode::kReadOnly).Check({});
  ASSERT_FALSE(report.problems.empty());
  for (const std::string& problem : report.problems) {
    EXPECT_THAT(problem, HasSubstr("tile " + testing::TileOfPlace(0).ToString()));
  }
}

TEST_F(PostgresTest, RolesMayDoWhatTheyMust) {
  cluster_->Execute("city",
                    "CREATE ROLE server LOGIN IN ROLE cairn_reader; "
                    "CREATE ROLE builder LOGIN IN ROLE cairn_builder; CREATE ROLE stranger LOGIN");
  MapStore reader = MapStore::Open(cluster_->Url("city", "server"), OpenMode::kReadWrite);
  EXPECT_EQ(reader.Snapshot().AllTiles(9).size(), 1u);
  EXPECT_EQ(ErrorCodeOf([&] { reader.BeginUpdate(); }), ErrorCode::kIo);
  MapStore builder = MapStore::Open(cluster_->Url("city", "builder"), OpenMode::kReadWrite);
  MapUpdate update = builder.BeginUpdate();
  PutPlace(1, 2, &update);
  update.RestoreVersion(MapVersion(1));
  update.PruneBefore(MapVersion(2));
  EXPECT_EQ(update.Publish(), MapVersion(3));
  EXPECT_EQ(
      ErrorCodeOf([&] { MapStore::Open(cluster_->Url("city", "stranger"), OpenMode::kReadOnly); }),
      ErrorCode::kIo);
}

TEST_F(PostgresTest, OtherDatabasesAreRefused) {
  const auto open = [](const std::string& url) {
    return ErrorCodeOf([&] { MapStore::Open(url, OpenMode::kReadOnly); });
  };
  EXPECT_EQ(open(cluster_->Url("none")), ErrorCode::kNotFound);
  EXPECT_EQ(open(cluster_->Url("city", "nobody")), ErrorCode::kNotFound);
  EXPECT_EQ(open(cluster_->CreateDatabase("empty")), ErrorCode::kNotFound);
  EXPECT_EQ(open(url_ + "&sslmode=require"), std::nullopt);  // Sockets need no TLS.
  EXPECT_EQ(open("postgresql:///city?host=/nonexistent"), ErrorCode::kUnavailable);
  testing::ExecuteRaw(url_, "INSERT INTO cairn_migrations VALUES (99, 'later')");
  EXPECT_EQ(open(url_), ErrorCode::kConflict);
  testing::ExecuteRaw(url_, "DELETE FROM cairn_migrations");
  EXPECT_EQ(open(url_), ErrorCode::kConflict);
}

TEST_F(PostgresTest, GeometriesAreForQgis) {
  EXPECT_THAT(RowsOf(url_,
                     "SELECT f_table_name, type, srid FROM geometry_columns "
                     "WHERE f_table_schema = 'cairn' AND f_table_name IN ('coverage', 'keyframes') "
                     "ORDER BY 1"),
              ElementsAre("coverage | POLYGON | 4326", "keyframes | POINT | 4326"));
  EXPECT_THAT(RowsOf(url_,
                     "SELECT count(*) FROM coverage AS c JOIN keyframes AS k "
                     "ON ST_Contains(c.geom, ST_Force2D(k.geom))"),
              ElementsAre("2"));
  EXPECT_THAT(RowsOf(url_, "SELECT name, num_keyframes FROM sessions"), ElementsAre("place 0 | 2"));
}

}  // namespace
}  // namespace cairn
