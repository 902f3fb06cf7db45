// Measures encoding and decoding of a tile of the paper's size, and encoding of descriptors.
#include <benchmark/benchmark.h>

#include <memory>

#include "storage/codebook/descriptor_codec.h"
#include "storage/tile/tile_codec.h"
#include "support/tile_builder.h"

namespace cairn {
namespace {

constexpr int kNumLandmarks = 200'000;
constexpr int kNumKeyframes = 1'000;
constexpr int kNumLandmarksPerKeyframe = 1'000;
constexpr int kNumDescriptors = 100'000;  // For the descriptor codec.

// 200,000 landmarks, 500,000 descriptors (1 to 4 each), 1,000 keyframes of 1,000 landmarks.
const Tile& PaperTile() {
  static const Tile tile = [] {
    testing::RandomTileOptions options;
    options.num_landmarks = kNumLandmarks;
    options.num_keyframes = kNumKeyframes;
    options.num_landmarks_per_keyframe = kNumLandmarksPerKeyframe;
    return testing::RandomTile(options);
  }();
  return tile;
}

void BM_EncodeTile(benchmark::State& state) {
  const Tile& tile = PaperTile();
  std::vector<uint8_t> blob;
  for (auto _ : state) {
    blob = EncodeTile(tile);
    benchmark::DoNotOptimize(blob.data());
  }
  if (!testing::SameTile(DecodeTile(blob), tile)) {
    state.SkipWithError("the decoded tile differs");
  }
  const auto size = static_cast<double>(blob.size());
  state.counters["bytes_per_landmark"] = size / static_cast<double>(tile.num_landmarks());
  state.counters["bytes_per_descriptor"] = size / static_cast<double>(tile.num_descriptors());
  state.counters["mebibytes"] = size / (1 << 20);
}

void BM_DecodeTile(benchmark::State& state) {
  const std::vector<uint8_t> blob = EncodeTile(PaperTile());
  Tile tile;
  for (auto _ : state) {
    tile = DecodeTile(blob);
    benchmark::DoNotOptimize(tile.codes.data());
  }
  if (!testing::SameTile(tile, PaperTile())) {
    state.SkipWithError("the decoded tile differs");
  }
  state.SetBytesProcessed(state.iterations() * static_cast<int64_t>(blob.size()));
}

void BM_EncodeDescriptors(benchmark::State& state) {
  const DescriptorCodec codec(std::make_shared<const Codebook>(testing::RandomCodebook()));
  std::mt19937 random(1);
  std::vector<uint8_t> codes(static_cast<size_t>(kNumDescriptors) * 8);
  std::generate(codes.begin(), codes.end(), [&] { return static_cast<uint8_t>(random()); });
  // A hundredth of the distance between words away from a word each.
  std::normal_distribution<float> noise(0.0f, 1e-4f);
  DescriptorMatrix projected = codec.Decode(codes.data(), kNumDescriptors);
  projected = projected.unaryExpr([&](float value) { return value + noise(random); });
  std::vector<uint8_t> encoded;
  for (auto _ : state) {
    encoded = codec.Encode(projected);
    benchmark::DoNotOptimize(encoded.data());
  }
  size_t num_different = 0;
  for (size_t i = 0; i < codes.size(); ++i) {
    num_different += codes[i] != encoded[i] ? 1 : 0;
  }
  if (num_different > codes.size() / 100) {  // Words of a random codebook can nearly coincide.
    state.SkipWithError("the words are not the nearest ones");
  }
  state.SetItemsProcessed(state.iterations() * kNumDescriptors);
}

BENCHMARK(BM_EncodeTile)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_DecodeTile)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_EncodeDescriptors)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace cairn
