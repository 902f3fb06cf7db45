// Tests two sessions of one place on real photos: size of the map, and queries before and after.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "eval/eval_query.h"
#include "ingest/colmap/colmap_reader.h"
#include "ingest/ingest_session.h"
#include "ingest/place/georegister.h"
#include "support/recognized.h"
#include "support/temp_dir.h"
#include "support/test_data.h"

namespace cairn {
namespace {

constexpr double kMaxBytesOfBoth = 1.25;  // Over those of one session.

struct RealPlace {
  ColmapInput input;
  std::string positions_path;  // Empty: the GPS of the photos.
  std::vector<std::string> names;

  Reconstruction Read(int begin, int step) const {
    ColmapInput some = input;
    for (size_t i = static_cast<size_t>(begin); i < names.size(); i += static_cast<size_t>(step)) {
      some.image_names.push_back(names[i]);
    }
    return ReadColmap(some);
  }
  Sim3d Place(const Reconstruction& reconstruction) const {
    const std::vector<CameraPosition> positions = positions_path.empty()
                                                      ? GpsPositions(reconstruction, 5.0)
                                                      : ReadCameraPositions(positions_path);
    // Ten photos along a street do not tell which way is up, and their EXIF is not read here.
    return Georegister(reconstruction, positions, {.up = UpSource::kTop}).ecef_from_world;
  }
};

RealPlace PlaceOf(const ColmapInput& input, const std::string& positions_path) {
  RealPlace place{input, positions_path, {}};
  for (const ReconImage& image : ReadColmap(input).images) {
    place.names.push_back(image.name);
  }
  std::sort(place.names.begin(), place.names.end());
  return place;
}

RealPlace Kitti() {
  const auto dir = testing::TestDataDir() / "kitti_vo_2x51";
  return PlaceOf({(dir / "colmap_model_seq1").string(), (dir / "database_seq1.db").string(), {}},
                 (dir / "georef_seq1.csv").string());
}

RealPlace Lund() {
  const auto dir = testing::TestDataDir() / "street_lund";
  return PlaceOf({(dir / "colmap_model").string(), (dir / "database.db").string(), {}}, "");
}

IngestReport Ingest(const RealPlace& place, const Reconstruction& session, const std::string& name,
                    MapStore* store) {
  IngestOptions options;
  options.session_name = name;
  return IngestSession(session, place.Place(session), options, store, {});
}

// Alternating photos are two sessions.
void ExpectSizeOfOne(const RealPlace& place) {
  const testing::TempDir dir;
  MapStore store = MapStore::Create(dir.File("halves.gpkg"));
  Ingest(place, place.Read(0, 2), "even", &store);
  const int64_t one = store.Snapshot().Info().payload_bytes;
  const IngestReport report = Ingest(place, place.Read(1, 2), "odd", &store);
  const int64_t both = store.Snapshot().Info().payload_bytes;
  std::printf("%lld bytes, with the second session %lld: %.3f; %lld merged, %lld new\n",
              static_cast<long long>(one), static_cast<long long>(both),
              static_cast<double>(both) / static_cast<double>(one),
              static_cast<long long>(report.changes.num_merged),
              static_cast<long long>(report.changes.num_new));
  EXPECT_GT(report.changes.num_merged, report.changes.num_new);
  EXPECT_LE(static_cast<double>(both), kMaxBytesOfBoth * static_cast<double>(one));
}

// Two photos of three are sessions, the third is a query of the map before and after the second.
void ExpectNoQueryLost(const RealPlace& place) {
  const testing::TempDir dir;
  MapStore store = MapStore::Create(dir.File("thirds.gpkg"));
  const Reconstruction first = place.Read(0, 3);
  Ingest(place, first, "first", &store);
  std::vector<EvalQuery> queries =
      QueriesFromReconstruction(place.Read(2, 3), place.Place(first), "");
  AddNoisyPriors({}, &queries);
  const std::vector<bool> before = testing::Recognized(queries, store);
  Ingest(place, place.Read(1, 3), "second", &store);
  const std::vector<bool> after = testing::Recognized(queries, store);
  int num_before = 0;
  for (size_t i = 0; i < queries.size(); ++i) {
    EXPECT_LE(before[i], after[i]) << queries[i].name;
    num_before += before[i] ? 1 : 0;
  }
  EXPECT_GT(num_before, static_cast<int>(queries.size()) * 3 / 4);
}

TEST(LivingMaps, KittiInTwoSessionsHasTheSizeOfOne) {
  CAIRN_SKIP_WITHOUT_DATA("kitti_vo_2x51");
  ExpectSizeOfOne(Kitti());
}

TEST(LivingMaps, LundInTwoSessionsHasTheSizeOfOne) {
  CAIRN_SKIP_WITHOUT_DATA("street_lund");
  ExpectSizeOfOne(Lund());
}

TEST(LivingMaps, ASecondSessionOfKittiLosesNoQuery) {
  CAIRN_SKIP_WITHOUT_DATA("kitti_vo_2x51");
  ExpectNoQueryLost(Kitti());
}

TEST(LivingMaps, ASecondSessionOfLundLosesNoQuery) {
  CAIRN_SKIP_WITHOUT_DATA("street_lund");
  ExpectNoQueryLost(Lund());
}

}  // namespace
}  // namespace cairn
