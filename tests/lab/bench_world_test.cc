#include "lab/bench/bench_world.h"

#include <gtest/gtest.h>

#include <memory>

#include "core/error.h"
#include "lab/bench/run_bench.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

BenchWorldOptions SmallWorld() {
  BenchWorldOptions options;
  options.landmarks_per_tile = 10'000;
  options.keyframes_per_tile = 60;
  options.num_keypoints = 400;
  options.num_queries = 4;
  return options;
}

TEST(BenchWorld, EveryAnswerIsRightAndTouchesEveryTile) {
  const testing::TempDir dir;
  const std::vector<EvalQuery> queries =
      BuildBenchWorld(SmallWorld(), dir.File("bench.gpkg"), nullptr);
  ASSERT_EQ(queries.size(), 4u);
  RunBenchOptions options;
  options.num_repeats = 1;
  const BenchFigures figures = RunBench(
      std::make_shared<const MapStore>(MapStore::Open(dir.File("bench.gpkg"), OpenMode::kReadOnly)),
      queries, options);
  EXPECT_EQ(figures.num_tiles, 4);
  EXPECT_EQ(figures.num_right, 4);
  EXPECT_GT(figures.tile_load_seconds, 0.0);
  EXPECT_GT(figures.plain_read_seconds, 0.0);
  for (const EvalAnswer& answer : figures.warm.answers) {
    EXPECT_EQ(answer.result.counters.num_tiles_searched, 4) << answer.name;
    EXPECT_EQ(answer.result.counters.num_tiles_loaded, 0) << answer.name;
  }
  EXPECT_LT(figures.same_landmark_distance, figures.other_landmark_distance);
}

TEST(BenchWorld, RefusesOptionsThatMakeNoSense) {
  BenchWorldOptions options;
  options.num_tiles = 3;
  EXPECT_THROW(options.Validate(), Error);
  options = {};
  options.mapped_fraction = 0.0;
  EXPECT_THROW(options.Validate(), Error);
}

}  // namespace
}  // namespace cairn
