// The sights of features that have not been used yet: the ledger by which no measurement is counted
// twice.
#ifndef CAIRN_FUSION_TRACKS_TRACK_TABLE_H_
#define CAIRN_FUSION_TRACKS_TRACK_TABLE_H_

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "core/camera.h"

namespace cairn::fusion {

// A feature seen in one frame. Features of different frames with the same id show the same point.
struct TrackedFeature {
  uint64_t track_id = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

// A sight of a track that no update has used. Whoever uses it takes it out of the table.
struct Observation {
  int64_t frame_id = 0;
  Eigen::Vector2d pixel;
  Eigen::Vector3d ray_in_cam;
  bool reserved = false;  // For the answer to a query: not to be used locally until it is there.
};

// What the map says of where a point is along the ray of a queried sight, besides what that sight
// has told already: direction_in_global' (x_in_global - point) = 0 within sigma_m.
struct MapDistance {
  Eigen::Vector3d x_in_global;          // The landmark.
  Eigen::Vector3d direction_in_global;  // From the camera to the landmark, a unit vector.
  double sigma_m = 0.0;                 // Positive.
  uint64_t tile_id = 0;
};

struct Track {
  uint64_t track_id = 0;
  int64_t last_frame_id = 0;                // In which it was seen, used or not.
  std::vector<Observation> observations;    // By frame.
  std::optional<MapDistance> map_distance;  // Of its point, until an update uses it.
};

// Not thread-safe. Bounded by max_tracks times the frames that are kept.
class TrackTable {
 public:
  explicit TrackTable(int max_tracks);

  // Enters the features of a new frame. Those with a pixel that the camera cannot unproject, with a
  // repeated id, or beyond the bound on the number of tracks are left out; returns how many were
  // entered.
  int AddFrame(int64_t frame_id, const Camera& camera, std::span<const TrackedFeature> features);

  std::vector<Track>& tracks() { return tracks_; }
  const std::vector<Track>& tracks() const { return tracks_; }

  // Nothing if there is no such track.
  Track* Find(uint64_t track_id);

  // Marks every sight of a frame as reserved, or as free again.
  void SetReserved(int64_t frame_id, bool reserved);

  // Forgets the sights of a frame.
  void DropFrame(int64_t frame_id);

  // Forgets tracks that were not seen in `frame_id` and of which nothing is reserved.
  void DropFinished(int64_t frame_id);

  void Clear();

 private:
  void RebuildIndex();

  size_t max_tracks_;
  std::vector<Track> tracks_;  // In order of first sight.
  std::unordered_map<uint64_t, size_t> index_;
};

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_TRACKS_TRACK_TABLE_H_
