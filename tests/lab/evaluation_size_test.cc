#include "lab/experiments/measure/evaluation_size.h"

#include <gtest/gtest.h>

namespace cairn {
namespace {

TEST(MapSizes, AreRatiosOfWhatTheMapHolds) {
  MapInfo info;
  info.num_tiles = 2;
  info.num_landmarks = 100;
  info.num_descriptors = 250;
  info.payload_bytes = 5000;
  info.file_bytes = 6000;
  const MapSizes sizes = MeasureMapSizes(info);
  EXPECT_DOUBLE_EQ(sizes.bytes_per_tile, 2500.0);
  EXPECT_DOUBLE_EQ(sizes.bytes_per_landmark, 50.0);
  EXPECT_DOUBLE_EQ(sizes.bytes_per_descriptor, 20.0);
  EXPECT_DOUBLE_EQ(sizes.descriptors_per_landmark, 2.5);
  EXPECT_DOUBLE_EQ(sizes.file_overhead, 0.2);
}

TEST(MapSizes, OfAnEmptyMapAreZero) {
  EXPECT_DOUBLE_EQ(MeasureMapSizes({}).bytes_per_landmark, 0.0);
}

}  // namespace
}  // namespace cairn
