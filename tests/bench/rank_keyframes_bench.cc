// Measures the ranking of keyframes and the search for their neighbors. There are four tiles of the
// paper's size (200,000 landmarks, 1,000 keyframes of 800 observations) and 4,000 matches of 1,000
// keypoints. Every fourth keypoint has a match that one keyframe of the map saw. `right` is the
// share of runs in which that keyframe comes first.
#include <benchmark/benchmark.h>

#include <memory>
#include <random>
#include <vector>

#include "engine/refinement/rank_keyframes.h"
#include "support/tile_builder.h"

namespace cairn {
namespace {

constexpr int kNumTiles = 4;
constexpr int kNumLandmarks = 200'000;  // Of a tile.
constexpr int kNumKeypoints = 1000;
constexpr int kMatchesPerKeypoint = 4;
constexpr KeyframeRef kSeen = {1, 500};  // The keyframe that the query resembles.

std::vector<TileView> MakeTiles() {
  const auto codebook = std::make_shared<const Codebook>(testing::RandomCodebook());
  std::vector<TileView> tiles;
  for (int i = 0; i < kNumTiles; ++i) {
    testing::RandomTileOptions options;
    options.num_landmarks = kNumLandmarks;
    options.max_descriptors_per_landmark = 1;
    options.num_keyframes = 1000;
    options.num_landmarks_per_keyframe = 800;
    options.first_landmark_id = 1 + static_cast<uint64_t>(i) * kNumLandmarks;
    options.seed = 1 + i;
    IndexOptions index;
    index.kind = IndexKind::kExhaustive;  // Nothing is matched here.
    tiles.push_back(
        {std::make_shared<const SearchableTile>(testing::RandomTile(options), codebook, index),
         Rigid3d(Eigen::Quaterniond::Identity(), {150.0 * (i % 2), 150.0 * (i / 2), 0})});
  }
  return tiles;
}

struct World {
  std::vector<TileView> tiles = MakeTiles();
  QueryContext query;
  std::vector<Correspondence> correspondences;

  World() {
    std::mt19937_64 random(1);
    query.keypoints.resize(kNumKeypoints);
    const auto seen =
        tiles[kSeen.tile_idx].tile->covisibility().LandmarksOfKeyframe(kSeen.keyframe_idx);
    for (int keypoint = 0; keypoint < kNumKeypoints; ++keypoint) {
      for (int rank = 0; rank < kMatchesPerKeypoint; ++rank) {
        Correspondence match;
        match.keypoint_idx = keypoint;
        match.tile_idx = static_cast<int>(random() % kNumTiles);
        match.landmark_idx = static_cast<uint32_t>(random() % kNumLandmarks);
        if (keypoint % 4 == 0 && rank == 0) {
          match.tile_idx = kSeen.tile_idx;
          match.landmark_idx = seen[random() % seen.size()];
        }
        match.x_in_anchor.setZero();
        correspondences.push_back(match);
      }
    }
  }
};

const World& SharedWorld() {
  static const World world;
  return world;
}

void BM_RankKeyframes(benchmark::State& state) {
  const World& world = SharedWorld();
  int64_t num_right = 0;
  for (auto _ : state) {
    const auto ranked =
        RankKeyframes(world.query, world.tiles, world.correspondences, RefinementOptions());
    num_right += !ranked.empty() && ranked[0].keyframe.tile_idx == kSeen.tile_idx &&
                 ranked[0].keyframe.keyframe_idx == kSeen.keyframe_idx;
  }
  state.counters["right"] =
      static_cast<double>(num_right) / static_cast<double>(state.iterations());
}
BENCHMARK(BM_RankKeyframes)->Unit(benchmark::kMicrosecond);

void BM_KeyframeNeighborhood(benchmark::State& state) {
  const World& world = SharedWorld();
  int64_t num_right = 0;
  for (auto _ : state) {
    const auto keyframes = KeyframeNeighborhood(world.tiles, kSeen, 4);
    num_right += keyframes.size() > 1 && keyframes[0].tile_idx == kSeen.tile_idx &&
                 keyframes[0].keyframe_idx == kSeen.keyframe_idx;
  }
  state.counters["right"] =
      static_cast<double>(num_right) / static_cast<double>(state.iterations());
}
BENCHMARK(BM_KeyframeNeighborhood)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace cairn
