// Tests that files of the first release stay readable. CAIRN_UPDATE_GOLDEN=1 rewrites them, which
// only a new format version may need.
#include <gtest/gtest.h>
#include <zstd.h>

#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "storage/codebook/codebook.h"
#include "storage/tile/tile_codec.h"
#include "support/golden_file.h"
#include "support/tile_builder.h"

namespace cairn {
namespace {

// The file's bytes; `current` where the files are to be written anew.
std::vector<uint8_t> Golden(const std::string& name, const std::vector<uint8_t>& current) {
  if (std::getenv("CAIRN_UPDATE_GOLDEN") != nullptr) {
    std::ofstream(testing::GoldenPath(name), std::ios::binary)
        .write(reinterpret_cast<const char*>(current.data()),
               static_cast<std::streamsize>(current.size()));
  }
  return testing::GoldenFile(name);
}

// Every field has a value of its own; no random numbers, so that it is the same everywhere.
Tile GoldenTile() {
  Tile tile;
  tile.id = TileId::Parse("32N-03048-36192");
  tile.codebook_id = CodebookId(5);
  tile.code_size = 2;
  tile.landmark_ids = {LandmarkId(1000), LandmarkId(7), LandmarkId(1001)};
  tile.history_begin = {0, 1, 3, 4};
  tile.history = {
      {SessionId(1), 3, 4}, {SessionId(), 200, 255}, {SessionId(2), 0, 5}, {SessionId(1), 2, 2}};
  tile.x_in_tile = {
      {-12.5f, 3.25f, 1.00390625f}, {74.0f, -74.99609375f, 0.0f}, {300.0f, 8.0f, -2.5f}};
  tile.sigma_codes = {10, 20, 255};
  tile.descriptor_begin = {0, 2, 2, 5};
  tile.codes = {0, 1, 2, 3, 4, 5, 6, 7, 254, 255};
  tile.orientation_codes = {0, 128, kNoOrientation, 17, 18};
  tile.size_codes = {90, 91, 0, 255, 100};
  tile.azimuth_codes = {255, 0, 64, 65, 66};
  tile.weight_codes = {1, 4, 8, 255, 9};
  Rigid3d pose;
  pose.rotation = Eigen::Quaterniond(0.5, -0.5, 0.5, 0.5);
  pose.translation = {1.5, -2.25, 100.125};
  tile.keyframes = {{KeyframeId(41), SessionId(1), pose},
                    {KeyframeId(40), SessionId(2), Rigid3d()}};
  tile.keyframe_begin = {0, 2, 3};
  tile.keyframe_landmarks = {0, 2, 1};
  return tile;
}

Codebook GoldenCodebook() {
  Codebook codebook;
  codebook.id = CodebookId(5);
  codebook.descriptor_type = "sift";
  codebook.mean = Eigen::Vector3f(0.25f, -1.0f, 3.0f);
  codebook.projection.resize(2, 3);
  codebook.projection << 1.0f, 0.5f, -0.25f, 0.0f, 2.0f, 8.0f;
  codebook.num_subspaces = 2;
  for (int i = 0; i < 512; ++i) {
    codebook.words.push_back(0.125f * static_cast<float>(i - 256));
  }
  codebook.same_landmark_distance_quantiles = {0.5f, 1.0f};
  codebook.other_landmark_distance_quantiles = {1.5f, 2.0f, 2.5f};
  return codebook;
}

TileLists GoldenLists() { return {.begin = {0, 2, 2, 5}, .members = {1, 4, 0, 2, 3}}; }

TEST(Golden, TileV1DecodesAndIsWrittenAgain) {
  const std::vector<uint8_t> golden =
      Golden("tile_v1.bin", EncodeTile(GoldenTile(), GoldenLists()));
  ASSERT_FALSE(golden.empty());
  TileLists lists;
  EXPECT_TRUE(testing::SameTile(DecodeTile(golden, {}, &lists), GoldenTile()));
  EXPECT_EQ(lists, GoldenLists());
  if (ZSTD_versionNumber() == 10504) {  // Others may compress differently.
    EXPECT_EQ(EncodeTile(GoldenTile(), GoldenLists()), golden);
  }
}

TEST(Golden, CodebookV1DecodesAndIsWrittenAgain) {
  const std::vector<uint8_t> golden = Golden("codebook_v1.bin", EncodeCodebook(GoldenCodebook()));
  const Codebook decoded = DecodeCodebook(golden.data(), golden.size(), CodebookId(5));
  EXPECT_EQ(decoded.mean, GoldenCodebook().mean);
  EXPECT_EQ(decoded.projection, GoldenCodebook().projection);
  EXPECT_EQ(decoded.words, GoldenCodebook().words);
  EXPECT_EQ(EncodeCodebook(decoded), golden);
}

}  // namespace
}  // namespace cairn
