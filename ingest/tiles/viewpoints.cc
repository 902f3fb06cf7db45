#include "ingest/tiles/viewpoints.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <unordered_map>

#include "core/check.h"
#include "ingest/tiles/landmark_history.h"
#include "ingest/tiles/tile_edit.h"
#include "ingest/tiles/viewpoint.h"

namespace cairn {
namespace {

// Scales at which detectors find keypoints, pixels.
constexpr double kMinKeypointPx = 0.8, kMaxKeypointPx = 32.0;

// Sessions whose keyframes a viewpoint keeps: the newest says what the place looks like now, and
// the one before is left if the newest is removed.
constexpr size_t kSessionsOfViewpoint = 2;
// Keyframes of one session that a viewpoint keeps once the session is not the newest. Photos of a
// walk have fewer; a video has a hundred.
constexpr int kKeyframesOfViewpoint = 16;

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

// The landmarks that no keyframe sees any more, with what decides whether a camera might see them.
class UnseenLandmarks {
 public:
  UnseenLandmarks(const Tile& tile, const ViewpointOptions& options)
      : cos_angle_(std::cos(options.angle_rad)) {
    std::vector<bool> is_seen(tile.num_landmarks(), false);
    for (const uint32_t landmark : tile.keyframe_landmarks) {
      is_seen[landmark] = true;
    }
    for (uint32_t i = 0; i < tile.num_landmarks(); ++i) {
      if (!is_seen[i]) {
        Append(tile, i);
      }
    }
  }

  // Calls visit(landmark) for each landmark in the image that one of its descriptors resembles:
  // from the same direction, and neither too small nor too large to be detected.
  template <typename Visit>
  void ForEachThatMightShow(const Rigid3d& cam_from_tile, const Camera& camera,
                            const Visit& visit) const {
    const Eigen::Vector3d center_in_tile = cam_from_tile.Inverse().translation;
    for (const Unseen& unseen : landmarks_) {
      const Eigen::Vector3d to_camera = center_in_tile - unseen.x_in_tile;
      if (IsLookable(unseen, to_camera, camera.focal_px()) &&
          IsInImage(camera, cam_from_tile * unseen.x_in_tile)) {
        visit(unseen.landmark);
      }
    }
  }

 private:
  struct Look {
    Eigen::Vector2d to_camera;  // Horizontal direction, unit.
    double size_m = 0.0;        // 0: unknown.
  };
  struct Unseen {
    uint32_t landmark = 0;
    uint32_t first_look = 0, end_look = 0;
    Eigen::Vector3d x_in_tile;
  };

  void Append(const Tile& tile, uint32_t landmark) {
    const auto first_look = static_cast<uint32_t>(looks_.size());
    for (uint32_t d = tile.descriptor_begin[landmark]; d < tile.descriptor_begin[landmark + 1];
         ++d) {
      const double azimuth_rad = AzimuthFromCode(tile.azimuth_codes[d]);
      looks_.push_back(
          {{std::cos(azimuth_rad), std::sin(azimuth_rad)}, SizeFromCode(tile.size_codes[d])});
    }
    landmarks_.push_back({landmark, first_look, static_cast<uint32_t>(looks_.size()),
                          tile.x_in_tile[landmark].cast<double>()});
  }

  bool IsLookable(const Unseen& unseen, const Eigen::Vector3d& to_camera, double focal_px) const {
    const double px_per_m = focal_px / to_camera.norm();
    const double least_cos = cos_angle_ * to_camera.head<2>().norm();
    return std::any_of(
        looks_.begin() + unseen.first_look, looks_.begin() + unseen.end_look,
        [&](const Look& look) {
          const double size_px = look.size_m * px_per_m;
          const bool has_size_seen =
              look.size_m == 0.0 || (size_px >= kMinKeypointPx && size_px <= kMaxKeypointPx);
          return has_size_seen && look.to_camera.dot(to_camera.head<2>()) >= least_cos;
        });
  }

  double cos_angle_;
  std::vector<Look> looks_;
  std::vector<Unseen> landmarks_;
};

// Counts chances keyframe by keyframe.
class ChanceCounter {
 public:
  ChanceCounter(const Tile& tile, const ViewpointOptions& options)
      : tile_(tile),
        index_(tile, options),
        unseen_(tile, options),
        chances_(tile.num_landmarks(), 0),
        last_keyframe_(tile.num_landmarks(), UINT32_MAX) {}

  void Add(uint32_t keyframe, const Camera& camera) {
    const Rigid3d& cam_from_tile = tile_.keyframes[keyframe].cam_from_tile;
    index_.ForEachSame(keyframe, [&](uint32_t other) {
      for (const uint32_t landmark : tile_.LandmarksOfKeyframe(other)) {
        if (last_keyframe_[landmark] == keyframe) {
          continue;
        }
        last_keyframe_[landmark] = keyframe;
        if (IsInImage(camera, cam_from_tile * tile_.x_in_tile[landmark].cast<double>())) {
          ++chances_[landmark];
        }
      }
    });
    unseen_.ForEachThatMightShow(cam_from_tile, camera,
                                 [&](uint32_t landmark) { ++chances_[landmark]; });
  }

  const std::vector<int>& chances() const { return chances_; }

 private:
  const Tile& tile_;
  ViewpointIndex index_;
  UnseenLandmarks unseen_;
  std::vector<int> chances_;
  std::vector<uint32_t> last_keyframe_;  // That looked at the landmark.
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
  CAIRN_CHECK(chances.size() == tile->num_landmarks(),
              "there must be one number for each landmark");
  std::vector<std::vector<HistoryEntry>> histories;
  for (size_t i = 0; i < chances.size(); ++i) {
    const std::span<const HistoryEntry> before = tile->HistoryOf(i);
    std::vector<HistoryEntry>& history = histories.emplace_back(before.begin(), before.end());
    const auto num_chances = static_cast<uint8_t>(std::min(chances[i], 255));
    if (!history.empty() && history.back().session_id == session_id) {
      HistoryEntry& own = history.back();
      own.num_chances = std::max(own.num_chances, num_chances);
    } else if (num_chances > 0) {
      AppendToHistory({session_id, 0, num_chances}, &history);
    }
  }
  ReplaceHistories(histories, tile);
}

std::vector<KeyframeId> ReplacedKeyframes(const Tile& tile, const ViewpointOptions& options) {
  const ViewpointIndex index(tile, options);
  SessionId newest{};
  for (const TileKeyframe& keyframe : tile.keyframes) {
    newest = std::max(newest, keyframe.session_id);
  }
  std::vector<bool> is_kept(tile.num_keyframes(), false);
  std::vector<KeyframeId> replaced;
  // Backward, so that the last photos of a session stay.
  for (auto k = static_cast<uint32_t>(tile.num_keyframes()); k-- > 0;) {
    const SessionId session_id = tile.keyframes[k].session_id;
    std::set<SessionId> newer;
    int num_kept = 0;  // Of the same session.
    index.ForEachSame(k, [&](uint32_t other) {
      const SessionId session_of_other = tile.keyframes[other].session_id;
      if (session_of_other > session_id) {
        newer.insert(session_of_other);
      }
      num_kept += session_of_other == session_id && is_kept[other] ? 1 : 0;
    });
    is_kept[k] = newer.size() < kSessionsOfViewpoint &&
                 (session_id == newest || num_kept < kKeyframesOfViewpoint);
    if (!is_kept[k]) {
      replaced.push_back(tile.keyframes[k].id);
    }
  }
  std::reverse(replaced.begin(), replaced.end());
  return replaced;
}

}  // namespace cairn
