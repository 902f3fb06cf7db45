#include "ingest/tiles/place_budget.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <unordered_set>
#include <vector>

#include "ingest/tiles/near_view.h"
#include "ingest/tiles/tile_edit.h"
#include "ingest/tiles/viewpoint.h"

namespace cairn {
namespace {

// A fourth session meets no light or season that would double the looks of a place.
constexpr size_t kSessionsUntilFull = 3;

// Mean stored bytes in tiles of a simulated city; those of a descriptor beside its code.
constexpr double kBytesOfDescriptor = 4.5, kBytesOfLandmark = 7.0, kBytesOfHistoryEntry = 1.1;
constexpr double kBytesOfKeyframe = 57.0, kBytesOfObservation = 0.6;

bool IsFull(const Tile& tile) {
  std::set<SessionId> sessions;
  for (const TileKeyframe& keyframe : tile.keyframes) {
    sessions.insert(keyframe.session_id);
  }
  for (const HistoryEntry& entry : tile.history) {
    sessions.insert(entry.session_id);
  }
  return sessions.size() >= kSessionsUntilFull;
}

// The keyframes of `fresh` without a keyframe of `known` nearby.
Tile OnNewGround(const Tile& known, const Tile& fresh) {
  std::vector<Viewpoint> known_viewpoints;
  for (const TileKeyframe& keyframe : known.keyframes) {
    known_viewpoints.push_back(ViewpointOf(keyframe));
  }
  const double cos_near = std::cos(kNearViewRad);
  return PickKeyframes(fresh, [&](const TileKeyframe& keyframe) {
    const Viewpoint mine = ViewpointOf(keyframe);
    return std::none_of(known_viewpoints.begin(), known_viewpoints.end(),
                        [&](const Viewpoint& other) {
                          return (other.center_in_tile - mine.center_in_tile).squaredNorm() <=
                                     kNearViewM * kNearViewM &&
                                 other.axis_in_tile.dot(mine.axis_in_tile) >= cos_near;
                        });
  });
}

// The bytes of the keyframes of `fresh` and of the landmarks that `known` lacks.
int64_t NewBytes(const Tile& known, const Tile& fresh) {
  std::unordered_set<uint64_t> known_ids;
  for (const LandmarkId id : known.landmark_ids) {
    known_ids.insert(Value(id));
  }
  std::set<uint32_t> new_landmarks;
  for (const uint32_t landmark : fresh.keyframe_landmarks) {
    if (!known_ids.contains(Value(fresh.landmark_ids[landmark]))) {
      new_landmarks.insert(landmark);
    }
  }
  const std::vector<uint32_t> picked(new_landmarks.begin(), new_landmarks.end());
  return EstimateBytes(PickLandmarks(fresh, picked));
}

}  // namespace

int64_t EstimateBytes(const Tile& tile) {
  return std::llround((tile.code_size + kBytesOfDescriptor) *
                          static_cast<double>(tile.num_descriptors()) +
                      kBytesOfLandmark * static_cast<double>(tile.num_landmarks()) +
                      kBytesOfHistoryEntry * static_cast<double>(tile.history.size()) +
                      kBytesOfKeyframe * static_cast<double>(tile.num_keyframes()) +
                      kBytesOfObservation * static_cast<double>(tile.keyframe_landmarks.size()));
}

std::optional<int64_t> BytesOfPlace(const Tile& known, const Tile& fresh, const Tile& admitted) {
  if (!IsFull(known)) {
    return std::nullopt;
  }
  const int64_t grown = EstimateBytes(known) + NewBytes(known, OnNewGround(known, admitted));
  const auto alone = std::llround(kBytesOverOneSession * static_cast<double>(EstimateBytes(fresh)));
  return std::max<int64_t>(grown, alone);
}

}  // namespace cairn
