#include "http/service/publication_time.h"

#include <gtest/gtest.h>

#include "support/temp_dir.h"

namespace cairn {
namespace {

TEST(PublicationTime, ReadsTimesAndNothingElse) {
  EXPECT_EQ(UnixSeconds("1970-01-01T00:00:00Z"), 0.0);
  EXPECT_EQ(UnixSeconds("2026-11-24T11:32:44Z"), 1'795'519'964.0);
  for (const char* text : {"", "yesterday", "2026-11-24", "2026-11-24T11:32"}) {
    EXPECT_EQ(UnixSeconds(text), 0.0) << text;
  }
}

TEST(PublicationTime, IsThatOfTheVersionOfTheSnapshot) {
  const testing::TempDir dir;
  const std::string path = dir.File("map.gpkg");
  MapStore::Create(path);
  const MapStore store = MapStore::Open(path, OpenMode::kReadOnly);
  const MapSnapshot snapshot = store.Snapshot();
  PublicationTime time;
  const double expected = UnixSeconds(snapshot.Versions(1).at(0).created_at);
  EXPECT_GT(expected, 1.7e9);
  EXPECT_EQ(time.UnixSecondsOf(snapshot, "a map"), expected);
  EXPECT_EQ(time.UnixSecondsOf(snapshot, "a map"), expected);
}

}  // namespace
}  // namespace cairn
