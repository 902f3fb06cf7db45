// The features that the cameras of a window see, and the points that the features show.
#ifndef CAIRN_LAB_RIVALS_FUSION_WINDOW_TRACKS_H_
#define CAIRN_LAB_RIVALS_FUSION_WINDOW_TRACKS_H_

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "core/camera.h"
#include "fusion/filter/filter_state.h"
#include "fusion/tracks/track_table.h"
#include "fusion/tracks/triangulate.h"
#include "lab/rivals/fusion/window_variables.h"

namespace cairn::fusion {

// A feature seen by one camera of the window.
struct WindowObservation {
  WindowCamera* camera = nullptr;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Eigen::Vector2d normalized = Eigen::Vector2d::Zero();  // On the plane z = 1.
};

// A landmark of the map.
struct MapLandmark {
  Eigen::Vector3d x_in_global = Eigen::Vector3d::Zero();
  double sigma_m = 0.0;  // Standard deviation per axis.
};

// One point. With `map_landmark`, the point is fixed by the map; otherwise it is a variable once
// triangulated.
struct WindowTrack {
  uint64_t track_id = 0;
  std::vector<WindowObservation> observations;  // Ordered by time.
  std::optional<MapLandmark> map_landmark;
  bool is_triangulated = false;
  Eigen::Vector3d x_in_local = Eigen::Vector3d::Zero();
};

// A track keeps its address until it is dropped; its storage is then reused. Not thread-safe.
class WindowTracks {
 public:
  WindowTracks(const Camera& camera, const Rig& rig) : camera_(camera), rig_(rig) {}

  // Adds the features of a camera. Leaves out features that cannot be unprojected.
  void AddFeatures(WindowCamera* camera, std::span<const TrackedFeature> features);

  // Returns nullptr if no camera of the window sees the track.
  WindowTrack* Find(uint64_t track_id);

  // Calls visit(WindowTrack*) in order of first observation.
  template <typename Visitor>
  void ForEach(const Visitor& visit) {
    for (WindowTrack& track : tracks_) {
      if (!track.observations.empty()) {
        visit(&track);
      }
    }
  }

  // Removes all observations of a camera.
  void DropCamera(const WindowCamera* camera);
  // Empties a track. The next observation starts a new one.
  void Forget(WindowTrack* track);

  // Triangulates a local track with at least two observations. Returns false and changes nothing if
  // that fails.
  bool TriangulateTrack(double sigma_px, const TriangulateOptions& options, WindowTrack* track);

 private:
  WindowTrack* FindOrAdd(uint64_t track_id);

  Camera camera_;
  Rig rig_;
  std::deque<WindowTrack> tracks_;
  std::vector<WindowTrack*> free_;
  std::unordered_map<uint64_t, WindowTrack*> index_;
};

}  // namespace cairn::fusion

#endif  // CAIRN_LAB_RIVALS_FUSION_WINDOW_TRACKS_H_
