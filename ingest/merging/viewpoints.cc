#include "ingest/merging/viewpoints.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <set>
#include <unordered_map>

#include "core/check.h"
#include "ingest/merging/landmark_history.h"
#include "ingest/tiling/tile_edit.h"

namespace cairn {
namespace {

// Scales at which detectors find keypoints, pixels.
constexpr double kMinKeypointPx = 0.8, kMaxKeypointPx = 32.0;

// Sessions whose keyframes a viewpoint keeps: the newest says what the place looks like now, and
// the one before is left if the newest is removed.
constexpr size_t kSessionsOfViewpoint = 2;

struct Viewpoint {
  Eigen::Vector3d center_in_tile;
  Eigen::Vector3d axis_in_tile;  // Optical axis, unit.
};

Viewpoint ViewpointOf(const TileKeyframe& keyframe) {
  const Rigid3d tile_from_cam = keyframe.cam_from_tile.Inverse();
  return {tile_from_cam.translation, tile_from_cam.rotation * Eigen::Vector3d::UnitZ()};
}

// Keyframes of a tile by place; finds those of the same viewpoint.
class ViewpointIndex {
 public:
  ViewpointIndex(const Tile& tile, const ViewpointOptions& options)
      : options_(options), cos_angle_(std::cos(options.angle_rad)) {
    for (uint32_t k = 0; k < tile.num_keyframes(); ++k) {
      viewpoints_.push_back(ViewpointOf(tile.keyframes[k]));
      cells_[CellOf(viewpoints_[k].center_in_tile, 0, 0)].push_back(k);
    }
  }

  const Viewpoint& of(uint32_t keyframe) const { return viewpoints_[keyframe]; }

  // Calls visit(other) for each keyframe of the same viewpoint, `keyframe` among them.
  template <typename Visit>
  void ForEachSame(uint32_t keyframe, const Visit& visit) const {
    const Viewpoint& mine = viewpoints_[keyframe];
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) {
        const auto cell = cells_.find(CellOf(mine.center_in_tile, dx, dy));
        if (cell == cells_.end()) {
          continue;
        }
        for (const uint32_t other : cell->second) {
          const Viewpoint& theirs = viewpoints_[other];
          if ((theirs.center_in_tile - mine.center_in_tile).norm() <= options_.radius_m &&
              theirs.axis_in_tile.dot(mine.axis_in_tile) >= cos_angle_) {
            visit(other);
          }
        }
      }
    }
  }

 private:
  int64_t CellOf(const Eigen::Vector3d& at, int dx, int dy) const {
    const auto x = static_cast<int64_t>(std::floor(at.x() / options_.radius_m)) + dx;
    const auto y = static_cast<int64_t>(std::floor(at.y() / options_.radius_m)) + dy;
    return (x << 32) ^ (y & 0xffffffff);
  }

  ViewpointOptions options_;
  double cos_angle_;
  std::vector<Viewpoint> viewpoints_;
  std::unordered_map<int64_t, std::vector<uint32_t>> cells_;
};

bool IsInImage(const Camera& camera, const Eigen::Vector3d& x_in_cam) {
  if (!(x_in_cam.z() > 0.1)) {
    return false;
  }
  const auto pixel = camera.Project(x_in_cam);
  return pixel && pixel->x() >= 0.0 && pixel->y() >= 0.0 && pixel->x() < camera.width_px() &&
         pixel->y() < camera.height_px();
}

// Counts chances keyframe by keyframe.
class ChanceCounter {
 public:
  ChanceCounter(const Tile& tile, const ViewpointOptions& options)
      : tile_(tile),
        options_(options),
        index_(tile, options),
        chances_(tile.num_landmarks(), 0),
        last_keyframe_(tile.num_landmarks(), UINT32_MAX),
        is_seen_(tile.num_landmarks(), false) {
    for (const uint32_t landmark : tile.keyframe_landmarks) {
      is_seen_[landmark] = true;
    }
    for (uint32_t i = 0; i < tile.num_landmarks(); ++i) {
      if (!is_seen_[i]) {
        unseen_.push_back(i);
      }
    }
  }

  void Add(uint32_t keyframe, const Camera& camera) {
    const Rigid3d& cam_from_tile = tile_.keyframes[keyframe].cam_from_tile;
    index_.ForEachSame(keyframe, [&](uint32_t other) {
      for (const uint32_t landmark : tile_.LandmarksOfKeyframe(other)) {
        if (last_keyframe_[landmark] == keyframe) {
          continue;
        }
        if (IsInImage(camera, cam_from_tile * tile_.x_in_tile[landmark].cast<double>())) {
          last_keyframe_[landmark] = keyframe;
          ++chances_[landmark];
        }
      }
    });
    for (const uint32_t landmark : unseen_) {
      if (MightSee(keyframe, camera, landmark)) {
        ++chances_[landmark];
      }
    }
  }

  const std::vector<int>& chances() const { return chances_; }

 private:
  bool MightSee(uint32_t keyframe, const Camera& camera, uint32_t landmark) const {
    const Eigen::Vector3d x_in_tile = tile_.x_in_tile[landmark].cast<double>();
    const Eigen::Vector3d to_camera = index_.of(keyframe).center_in_tile - x_in_tile;
    const double azimuth_rad = std::atan2(to_camera.y(), to_camera.x());
    const double px_per_m = camera.focal_px() / to_camera.norm();
    for (uint32_t d = tile_.descriptor_begin[landmark]; d < tile_.descriptor_begin[landmark + 1];
         ++d) {
      const double turn_rad = std::remainder(azimuth_rad - AzimuthFromCode(tile_.azimuth_codes[d]),
                                             2.0 * std::numbers::pi);
      const double size_px = SizeFromCode(tile_.size_codes[d]) * px_per_m;
      if (std::abs(turn_rad) <= options_.angle_rad && size_px >= kMinKeypointPx &&
          size_px <= kMaxKeypointPx) {
        return IsInImage(camera, tile_.keyframes[keyframe].cam_from_tile * x_in_tile);
      }
    }
    return false;
  }

  const Tile& tile_;
  const ViewpointOptions& options_;
  ViewpointIndex index_;
  std::vector<int> chances_;
  std::vector<uint32_t> last_keyframe_;  // That counted the landmark.
  std::vector<bool> is_seen_;            // By any keyframe.
  std::vector<uint32_t> unseen_;
};

}  // namespace

std::vector<int> CountChances(const Tile& tile, SessionId session_id,
                              const std::map<KeyframeId, const Camera*>& cameras,
                              const ViewpointOptions& options) {
  ChanceCounter counter(tile, options);
  for (uint32_t k = 0; k < tile.num_keyframes(); ++k) {
    if (tile.keyframes[k].session_id == session_id) {
      counter.Add(k, *cameras.at(tile.keyframes[k].id));
    }
  }
  return counter.chances();
}

void NoteChances(const std::vector<int>& chances, SessionId session_id, Tile* tile) {
  CAIRN_CHECK(chances.size() == tile->num_landmarks(), "one number a landmark");
  std::vector<std::vector<LandmarkSighting>> histories;
  for (size_t i = 0; i < chances.size(); ++i) {
    const std::span<const LandmarkSighting> before = tile->SightingsOf(i);
    std::vector<LandmarkSighting>& history = histories.emplace_back(before.begin(), before.end());
    const auto num_chances = static_cast<uint8_t>(std::min(chances[i], 255));
    if (!history.empty() && history.back().session_id == session_id) {
      LandmarkSighting& own = history.back();
      own.num_chances = std::max(own.num_chances, num_chances);
    } else if (num_chances > 0) {
      AppendSighting({session_id, 0, num_chances}, &history);
    }
  }
  ReplaceSightings(histories, tile);
}

std::vector<KeyframeId> ReplacedKeyframes(const Tile& tile, const ViewpointOptions& options) {
  const ViewpointIndex index(tile, options);
  std::vector<KeyframeId> replaced;
  for (uint32_t k = 0; k < tile.num_keyframes(); ++k) {
    std::set<SessionId> newer;
    index.ForEachSame(k, [&](uint32_t other) {
      if (tile.keyframes[other].session_id > tile.keyframes[k].session_id) {
        newer.insert(tile.keyframes[other].session_id);
      }
    });
    if (newer.size() >= kSessionsOfViewpoint) {
      replaced.push_back(tile.keyframes[k].id);
    }
  }
  return replaced;
}

}  // namespace cairn
