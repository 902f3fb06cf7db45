#include "ingest/tiles/admit_landmarks.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_set>

#include "ingest/tiles/place_budget.h"

namespace cairn {
namespace {

// A photo on new ground sees less than this share of what it needs in the map.
constexpr double kShareOfNewGround = 0.25;
// A photo needs this share of what it saw, so that two sessions of a street take 1.2 times the
// bytes of one. See docs/decisions/0028-a-place-has-its-size-after-three-sessions.md.
constexpr double kNeededShare = 0.55;

std::vector<std::vector<uint32_t>> KeyframesOfLandmarks(const Tile& tile) {
  std::vector<std::vector<uint32_t>> keyframes(tile.num_landmarks());
  for (uint32_t k = 0; k < tile.num_keyframes(); ++k) {
    for (const uint32_t landmark : tile.LandmarksOfKeyframe(k)) {
      keyframes[landmark].push_back(k);
    }
  }
  return keyframes;
}

// How much more the session saw than the map can hold of sessions like those it knows; at least 1.
double Excess(const Tile& known, const Tile& fresh) {
  const auto most_bytes = kBytesOverOneSession * static_cast<double>(EstimateBytes(known));
  return std::max(1.0, static_cast<double>(EstimateBytes(fresh)) / std::max(1.0, most_bytes));
}

// New landmarks that each keyframe needs.
std::vector<int> NumMissing(const Tile& known, const Tile& fresh, const std::vector<int>& num_known,
                            int enough_landmarks) {
  const double excess = Excess(known, fresh);
  std::vector<int> num_missing;
  for (size_t k = 0; k < fresh.num_keyframes(); ++k) {
    const auto num_seen = static_cast<double>(fresh.LandmarksOfKeyframe(k).size());
    const double usual = std::min<double>(enough_landmarks, std::ceil(kNeededShare * num_seen));
    const double needed = std::min(num_seen, std::ceil(excess * usual));
    num_missing.push_back(num_known[k] < kShareOfNewGround * needed
                              ? std::numeric_limits<int>::max()
                              : static_cast<int>(needed) - num_known[k]);
  }
  return num_missing;
}

}  // namespace

std::vector<uint32_t> AdmitLandmarks(const Tile& known, const Tile& fresh, int enough_landmarks) {
  std::unordered_set<uint64_t> known_ids;
  for (const LandmarkId id : known.landmark_ids) {
    known_ids.insert(Value(id));
  }
  const std::vector<std::vector<uint32_t>> keyframes = KeyframesOfLandmarks(fresh);
  std::vector<int> num_known(fresh.num_keyframes(), 0);
  std::vector<uint32_t> admitted, others;
  for (uint32_t i = 0; i < fresh.num_landmarks(); ++i) {
    const bool is_known = known_ids.contains(Value(fresh.landmark_ids[i]));
    (is_known ? admitted : others).push_back(i);
    if (is_known) {
      for (const uint32_t k : keyframes[i]) {
        ++num_known[k];
      }
    }
  }
  std::stable_sort(others.begin(), others.end(), [&](uint32_t a, uint32_t b) {
    return keyframes[a].size() > keyframes[b].size();
  });
  std::vector<int> num_missing = NumMissing(known, fresh, num_known, enough_landmarks);
  for (const uint32_t i : others) {
    const bool is_needed = std::any_of(keyframes[i].begin(), keyframes[i].end(),
                                       [&](uint32_t k) { return num_missing[k] > 0; });
    if (!is_needed) {
      continue;
    }
    admitted.push_back(i);
    for (const uint32_t k : keyframes[i]) {
      --num_missing[k];
    }
  }
  std::sort(admitted.begin(), admitted.end());
  return admitted;
}

}  // namespace cairn
