// Keeps the observations that no update has used yet, so that no measurement is counted twice.
#ifndef CAIRN_FUSION_TRACKS_TRACK_TABLE_H_
#define CAIRN_FUSION_TRACKS_TRACK_TABLE_H_

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "core/camera.h"
#include "core/features/tracked_feature.h"

namespace cairn::fusion {

// Most features that the filter tracks at a time.
inline constexpr int kMaxTrackedFeatures = 1024;

// An observation that no update has used. The update that uses an observation must remove it from
// the table.
struct Observation {
  int64_t frame_id = 0;
  Eigen::Vector2d pixel;
  Eigen::Vector3d ray_in_cam;
  // Reserved for the answer to a query. Local updates must not use this observation until the
  // answer is there.
  bool reserved = false;
};

// The map's knowledge of a point along the ray of a queried observation, beyond what that
// observation has already told: direction_in_global' (x_in_global - point) = 0 with standard
// deviation sigma_m.
struct MapDistance {
  Eigen::Vector3d x_in_global;          // The landmark.
  Eigen::Vector3d direction_in_global;  // Unit vector from the camera to the landmark.
  double sigma_m = 0.0;                 // Positive.
  uint64_t tile_id = 0;
};

struct Track {
  uint64_t track_id = 0;
  int64_t last_frame_id = 0;                // Last frame that saw the track, used or not.
  std::vector<Observation> observations;    // In order of frames.
  std::optional<MapDistance> map_distance;  // Kept until an update uses it.
};

// Memory is bounded by max_tracks times the number of kept frames. Not thread-safe.
class TrackTable {
 public:
  explicit TrackTable(int max_tracks);

  // Adds the features of a new frame and returns how many were added. Leaves out a feature if the
  // camera cannot unproject its pixel, if its id is repeated in the frame, or if the table is full.
  int AddFrame(int64_t frame_id, const Camera& camera, std::span<const TrackedFeature> features);

  std::vector<Track>& tracks() { return tracks_; }
  const std::vector<Track>& tracks() const { return tracks_; }

  // Returns nullptr if there is no such track.
  Track* Find(uint64_t track_id);
  const Track* Find(uint64_t track_id) const;

  // Marks every observation of a frame as reserved or unreserved.
  void SetReserved(int64_t frame_id, bool reserved);

  // Removes all observations of a frame.
  void DropFrame(int64_t frame_id);

  // Removes the tracks that `frame_id` did not see and that have no reserved observations.
  void DropFinished(int64_t frame_id);

  void Clear();

 private:
  void RebuildIndex();

  size_t max_tracks_;
  std::vector<Track> tracks_;  // Ordered by first observation.
  std::unordered_map<uint64_t, size_t> index_;
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_TRACKS_TRACK_TABLE_H_
