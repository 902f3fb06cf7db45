#include "lab/city/city_world.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <string>
#include <unordered_set>
#include <vector>

#include "core/error.h"
#include "engine/localizer.h"
#include "eval/evaluation.h"
#include "storage/map/map_store.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

class QuickWorld : public ::testing::Test {
 protected:
  std::vector<EvalQuery> Build(const CityWorldOptions& options, const std::string& name) {
    return BuildCityWorld(options, Path(name), {});
  }
  std::string Path(const std::string& name) const { return dir_.File(name); }

  static std::string TilesOf(const std::string& path) {
    const MapStore store = MapStore::Open(path, OpenMode::kReadOnly);
    const MapSnapshot map = store.Snapshot();
    std::string bytes;
    for (const TileRecord& tile : map.AllTiles(1000)) {
      const LargeVector<uint8_t> payload = map.LoadPayload(tile.payload_id);
      bytes.append(payload.begin(), payload.end());
    }
    return bytes;
  }

  testing::TempDir dir_;
};

TEST_F(QuickWorld, IsTheSameOnAnyNumberOfThreads) {
  CityWorldOptions options = CityWorldPreset(CityCharacter::kOldTown, CityWorldSize::kQuick);
  options.num_threads = 1;
  const std::vector<EvalQuery> one = Build(options, "one.gpkg");
  options.num_threads = 3;
  const std::vector<EvalQuery> three = Build(options, "three.gpkg");
  ASSERT_EQ(one.size(), 20u);
  EXPECT_EQ(TilesOf(Path("one.gpkg")), TilesOf(Path("three.gpkg")));
  EXPECT_GT(TilesOf(Path("one.gpkg")).size(), 10'000u);
  for (size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].query.features.descriptors, three[i].query.features.descriptors);
    EXPECT_EQ(one[i].cam_from_ecef.translation, three[i].cam_from_ecef.translation);
  }
}

TEST_F(QuickWorld, CanBeLocalizedIn) {
  for (const CityCharacter character : {CityCharacter::kOldTown, CityCharacter::kSuburb}) {
    const CityWorldOptions options = CityWorldPreset(character, CityWorldSize::kQuick);
    const std::string path = Path(CityCharacterName(character));
    const std::vector<EvalQuery> queries = Build(options, path);
    const auto store = std::make_shared<const MapStore>(MapStore::Open(path, OpenMode::kReadOnly));
    const Localizer localizer(store, {}, size_t{1} << 30);
    const EvalReport report = Evaluate(
        queries, [&](const EvalQuery& query) { return localizer.Localize(query.query); }, {});
    int num_right = 0;
    for (const EvalAnswer& answer : report.answers) {
      num_right += answer.position_error_m < 3.0 && answer.rotation_error_rad < 0.17;
    }
    EXPECT_GE(num_right, 4) << CityCharacterName(character);
  }
}

TEST_F(QuickWorld, AMapThatExistsIsNotOverwritten) {
  const CityWorldOptions options = CityWorldPreset(CityCharacter::kGrid, CityWorldSize::kQuick);
  Build(options, "map.gpkg");
  EXPECT_THROW(Build(options, "map.gpkg"), Error);
}

TEST_F(QuickWorld, RefusesWhatCannotBe) {
  CityWorldOptions options = CityWorldPreset(CityCharacter::kGrid, CityWorldSize::kQuick);
  options.queries.noise.gps_median_m = -1.0;
  EXPECT_THAT(
      [&] { Build(options, "map.gpkg"); },
      ::testing::ThrowsMessage<Error>(::testing::HasSubstr("queries.noise.gps_median_m = -1")));
  options = CityWorldPreset(CityCharacter::kGrid, CityWorldSize::kQuick);
  options.mapping.noise.deformation_m = -0.1;
  EXPECT_THAT([&] { Build(options, "map.gpkg"); },
              ::testing::ThrowsMessage<Error>(::testing::HasSubstr("mapping.noise.deformation_m")));
  options = CityWorldPreset(CityCharacter::kGrid, CityWorldSize::kQuick);
  options.mapping.num_passes = 0;
  EXPECT_THAT([&] { Build(options, "map.gpkg"); },
              ::testing::ThrowsMessage<Error>(::testing::HasSubstr("nearest possible value is 1")));
}

TEST(CityWorldSize, NamesAreReadBack) {
  for (const auto size : {CityWorldSize::kQuick, CityWorldSize::kMedium, CityWorldSize::kPaper}) {
    EXPECT_EQ(CityWorldSizeFromName(CityWorldSizeName(size)), size);
  }
  EXPECT_THROW(CityWorldSizeFromName("huge"), Error);
}

}  // namespace
}  // namespace cairn
