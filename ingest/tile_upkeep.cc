#include "ingest/tile_upkeep.h"

#include <algorithm>
#include <set>
#include <span>
#include <utility>

#include "ingest/tiles/place_budget.h"
#include "ingest/tiles/tile_edit.h"

namespace cairn {
namespace {

// Each round comes within some percent of the wanted bytes.
constexpr int kMaxSelectionRounds = 6;

struct Counts {
  int64_t num_landmarks = 0;
  int64_t num_descriptors = 0;
};

// Reduces the budget of a selection that makes a tile of `bytes`, so that the tile gets to
// `max_bytes`, but not below `least`. Keyframes stay whatever the budget is.
void ReduceBudget(const Tile& selected, int64_t bytes, int64_t max_bytes, const Counts& least,
                  LandmarkSelectionOptions* options) {
  const int64_t fixed = EstimateBytes(PickLandmarks(selected, {}));
  const double share = std::clamp(static_cast<double>(max_bytes - fixed) /
                                      static_cast<double>(std::max<int64_t>(1, bytes - fixed)),
                                  0.5, 1.0);
  const auto reduce = [&](size_t count, int64_t least_count) {
    return std::max(least_count, static_cast<int64_t>(share * static_cast<double>(count)) - 1);
  };
  options->max_descriptors = reduce(selected.num_descriptors(), least.num_descriptors);
  if (options->max_landmarks > 0) {
    options->max_landmarks = reduce(selected.num_landmarks(), least.num_landmarks);
  }
}

}  // namespace

Tile WithoutFaded(const Tile& tile, const UpkeepOptions& upkeep, const SessionTimes& times) {
  std::vector<uint32_t> existing;
  for (uint32_t i = 0; i < tile.num_landmarks(); ++i) {
    if (ExistenceProbability(tile.HistoryOf(i), times, upkeep.persistence) >=
        upkeep.least_existence) {
      existing.push_back(i);
    }
  }
  return existing.size() == tile.num_landmarks() ? tile : PickLandmarks(tile, existing);
}

Tile WithoutKeyframes(const Tile& tile, const std::vector<KeyframeId>& keyframes) {
  const std::set<KeyframeId> gone(keyframes.begin(), keyframes.end());
  return PickKeyframes(tile,
                       [&](const TileKeyframe& keyframe) { return !gone.contains(keyframe.id); });
}

std::vector<double> RateByHistory(const Tile& tile, const SessionTimes& times,
                                  const PersistenceOptions& persistence, int min_observations) {
  std::vector<double> rates(tile.num_landmarks());
  for (size_t i = 0; i < rates.size(); ++i) {
    rates[i] = min_observations + ExpectedObservations(tile.HistoryOf(i), times, persistence);
  }
  return rates;
}

Tile SelectLandmarks(const Tile& tile, std::vector<double> rates, std::optional<int64_t> max_bytes,
                     const LandmarkSelectionOptions& options, const LandmarkSelector& selector) {
  VisibilityGraph graph;
  graph.num_observations = std::move(rates);
  for (size_t k = 0; k < tile.num_keyframes(); ++k) {
    const std::span<const uint32_t> landmarks = tile.LandmarksOfKeyframe(k);
    graph.landmarks_of_keyframe.emplace_back(landmarks.begin(), landmarks.end());
  }
  std::vector<int> num_descriptors(tile.num_landmarks());
  for (size_t i = 0; i < num_descriptors.size(); ++i) {
    num_descriptors[i] = static_cast<int>(tile.descriptor_begin[i + 1] - tile.descriptor_begin[i]);
  }
  LandmarkSelectionOptions reduced = options;
  Tile selected = PickLandmarks(tile, selector.Select(graph, num_descriptors));
  // A session of thousands of photos can bring more bytes of keyframes than the tile may have.
  const Counts least = {
      .num_landmarks = static_cast<int64_t>(selected.num_landmarks() + 1) / 2,
      .num_descriptors = static_cast<int64_t>(selected.num_descriptors() + 1) / 2};
  for (int round = 0; max_bytes && round < kMaxSelectionRounds; ++round) {
    const int64_t bytes = EstimateBytes(selected);
    if (bytes <= *max_bytes) {
      break;
    }
    ReduceBudget(selected, bytes, *max_bytes, least, &reduced);
    selected = PickLandmarks(tile, MakeLandmarkSelector(reduced)->Select(graph, num_descriptors));
  }
  return selected;
}

}  // namespace cairn
