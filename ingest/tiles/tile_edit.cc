#include "ingest/tiles/tile_edit.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/check.h"

namespace cairn {
namespace {

constexpr uint32_t kDropped = std::numeric_limits<uint32_t>::max();

template <typename T>
void Append(const std::vector<T>& source, std::vector<T>* target) {
  target->insert(target->end(), source.begin(), source.end());
}

void RequireSameTile(const Tile& a, const Tile& b) {
  CAIRN_CHECK(a.id == b.id && a.codebook_id == b.codebook_id && a.code_size == b.code_size,
              "only contents of one tile in one codebook can be joined");
}

// Appends elements [begin, end) times `width`.
template <typename T>
void AppendRange(const std::vector<T>& source, size_t begin, size_t end, std::vector<T>* target,
                 size_t width = 1) {
  target->insert(target->end(), source.begin() + static_cast<std::ptrdiff_t>(begin * width),
                 source.begin() + static_cast<std::ptrdiff_t>(end * width));
}

// Appends offsets without their leading 0, moved up by what was there before.
void AppendOffsets(const std::vector<uint32_t>& source, std::vector<uint32_t>* target) {
  const uint32_t base = target->back();
  for (size_t i = 1; i < source.size(); ++i) {
    target->push_back(base + source[i]);
  }
}

// Copies a keyframe and those of its landmarks that have a new index.
void AppendKeyframe(const Tile& source, size_t keyframe_idx, const std::vector<uint32_t>& new_idx,
                    Tile* target) {
  const size_t begin = target->keyframe_landmarks.size();
  for (const uint32_t landmark_idx : source.LandmarksOfKeyframe(keyframe_idx)) {
    if (new_idx[landmark_idx] != kDropped) {
      target->keyframe_landmarks.push_back(new_idx[landmark_idx]);
    }
  }
  std::sort(target->keyframe_landmarks.begin() + static_cast<std::ptrdiff_t>(begin),
            target->keyframe_landmarks.end());
  target->keyframes.push_back(source.keyframes[keyframe_idx]);
  target->keyframe_begin.push_back(static_cast<uint32_t>(target->keyframe_landmarks.size()));
}

// Copies the landmarks in the order given and the keyframes for which `keep_keyframe` is true.
template <typename KeepKeyframe>
Tile Pick(const Tile& tile, std::span<const uint32_t> landmarks,
          const KeepKeyframe& keep_keyframe) {
  Tile picked = EmptyTile(tile.id, tile.codebook_id, tile.code_size);
  std::vector<uint32_t> new_idx(tile.num_landmarks(), kDropped);
  for (const uint32_t landmark_idx : landmarks) {
    CAIRN_CHECK(new_idx[landmark_idx] == kDropped, "a landmark may occur only once");
    new_idx[landmark_idx] = static_cast<uint32_t>(picked.num_landmarks());
    AppendLandmark(tile, landmark_idx, &picked);
  }
  for (size_t k = 0; k < tile.num_keyframes(); ++k) {
    if (keep_keyframe(tile.keyframes[k])) {
      AppendKeyframe(tile, k, new_idx, &picked);
    }
  }
  return picked;
}

}  // namespace

void AppendLandmark(const Tile& source, uint32_t landmark_idx, Tile* target) {
  target->landmark_ids.push_back(source.landmark_ids[landmark_idx]);
  target->x_in_tile.push_back(source.x_in_tile[landmark_idx]);
  target->sigma_codes.push_back(source.sigma_codes[landmark_idx]);
  AppendRange(source.history, source.history_begin[landmark_idx],
              source.history_begin[landmark_idx + 1], &target->history);
  target->history_begin.push_back(static_cast<uint32_t>(target->history.size()));
  const size_t begin = source.descriptor_begin[landmark_idx];
  const size_t end = source.descriptor_begin[landmark_idx + 1];
  AppendRange(source.codes, begin, end, &target->codes, source.code_size);
  AppendRange(source.orientation_codes, begin, end, &target->orientation_codes);
  AppendRange(source.size_codes, begin, end, &target->size_codes);
  AppendRange(source.azimuth_codes, begin, end, &target->azimuth_codes);
  AppendRange(source.weight_codes, begin, end, &target->weight_codes);
  target->descriptor_begin.push_back(static_cast<uint32_t>(target->num_descriptors()));
}

Tile EmptyTile(TileId tile_id, CodebookId codebook_id, int code_size) {
  Tile tile;
  tile.id = tile_id;
  tile.codebook_id = codebook_id;
  tile.code_size = code_size;
  tile.descriptor_begin = {0};
  tile.history_begin = {0};
  tile.keyframe_begin = {0};
  return tile;
}

Tile PickLandmarks(const Tile& tile, std::span<const uint32_t> landmarks) {
  return Pick(tile, landmarks, [](const TileKeyframe&) { return true; });
}

void ReplaceHistories(const std::vector<std::vector<HistoryEntry>>& histories, Tile* tile) {
  CAIRN_CHECK(histories.size() == tile->num_landmarks(),
              "there must be one history for each landmark");
  tile->history.clear();
  tile->history_begin = {0};
  for (const std::vector<HistoryEntry>& of_landmark : histories) {
    Append(of_landmark, &tile->history);
    tile->history_begin.push_back(static_cast<uint32_t>(tile->history.size()));
  }
}

Tile PickKeyframes(const Tile& tile, const std::function<bool(const TileKeyframe&)>& keep) {
  std::vector<uint32_t> landmarks(tile.num_landmarks());
  std::iota(landmarks.begin(), landmarks.end(), 0u);
  return Pick(tile, landmarks, keep);
}

Tile WithoutSession(Tile tile, SessionId session_id) {
  std::vector<std::vector<HistoryEntry>> histories;
  std::vector<uint32_t> seen_by_others;
  for (uint32_t i = 0; i < tile.num_landmarks(); ++i) {
    const std::span<const HistoryEntry> all = tile.HistoryOf(i);
    std::vector<HistoryEntry>& others = histories.emplace_back(all.begin(), all.end());
    const bool had_session = std::erase_if(others, [&](const HistoryEntry& entry) {
                               return entry.session_id == session_id;
                             }) > 0;
    const bool is_seen = std::any_of(others.begin(), others.end(),
                                     [](const auto& entry) { return entry.num_observations > 0; });
    if (is_seen || !had_session) {
      seen_by_others.push_back(i);
    }
  }
  ReplaceHistories(histories, &tile);
  return Pick(tile, seen_by_others,
              [&](const TileKeyframe& keyframe) { return keyframe.session_id != session_id; });
}

Tile CutKeyframes(const Tile& tile, const std::function<bool(const TileKeyframe&)>& keep,
                  bool and_unseen) {
  std::vector<bool> is_seen(tile.num_landmarks(), false);
  std::vector<bool> is_kept(tile.num_landmarks(), false);
  for (size_t k = 0; k < tile.num_keyframes(); ++k) {
    const bool keeps = keep(tile.keyframes[k]);
    for (const uint32_t landmark_idx : tile.LandmarksOfKeyframe(k)) {
      is_seen[landmark_idx] = true;
      is_kept[landmark_idx] = is_kept[landmark_idx] || keeps;
    }
  }
  std::vector<uint32_t> landmarks;
  for (uint32_t i = 0; i < tile.num_landmarks(); ++i) {
    if (is_kept[i] || (and_unseen && !is_seen[i])) {
      landmarks.push_back(i);
    }
  }
  return Pick(tile, landmarks, keep);
}

void AppendTile(const Tile& other, Tile* tile) {
  RequireSameTile(other, *tile);
  const auto num_landmarks = static_cast<uint32_t>(tile->num_landmarks());
  Append(other.landmark_ids, &tile->landmark_ids);
  Append(other.x_in_tile, &tile->x_in_tile);
  Append(other.sigma_codes, &tile->sigma_codes);
  AppendOffsets(other.descriptor_begin, &tile->descriptor_begin);
  AppendOffsets(other.history_begin, &tile->history_begin);
  Append(other.history, &tile->history);
  Append(other.codes, &tile->codes);
  Append(other.orientation_codes, &tile->orientation_codes);
  Append(other.size_codes, &tile->size_codes);
  Append(other.azimuth_codes, &tile->azimuth_codes);
  Append(other.weight_codes, &tile->weight_codes);
  Append(other.keyframes, &tile->keyframes);
  AppendOffsets(other.keyframe_begin, &tile->keyframe_begin);
  for (const uint32_t landmark_idx : other.keyframe_landmarks) {
    tile->keyframe_landmarks.push_back(num_landmarks + landmark_idx);
  }
}

void AppendMissing(const Tile& other, Tile* tile) {
  RequireSameTile(other, *tile);
  std::unordered_map<LandmarkId, uint32_t> idx_of_id;
  for (uint32_t i = 0; i < tile->num_landmarks(); ++i) {
    idx_of_id.emplace(tile->landmark_ids[i], i);
  }
  std::vector<uint32_t> new_idx;
  for (uint32_t i = 0; i < other.num_landmarks(); ++i) {
    const auto [found, is_missing] =
        idx_of_id.emplace(other.landmark_ids[i], static_cast<uint32_t>(tile->num_landmarks()));
    if (is_missing) {
      AppendLandmark(other, i, tile);
    }
    new_idx.push_back(found->second);
  }
  for (size_t k = 0; k < other.num_keyframes(); ++k) {
    AppendKeyframe(other, k, new_idx, tile);
  }
}

}  // namespace cairn
