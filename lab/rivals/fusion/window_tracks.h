// The features that the cameras of a window see, and what point each of them shows.
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

// A feature in one camera of the window.
struct WindowSight {
  WindowCamera* camera = nullptr;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Eigen::Vector2d normalized = Eigen::Vector2d::Zero();  // On the plane z = 1.
};

// A landmark of the map.
struct MapLandmark {
  Eigen::Vector3d x_in_global = Eigen::Vector3d::Zero();
  double sigma_m = 0.0;  // Standard deviation per axis.
};

// One point: of the map if `map_landmark` is there, else a variable once it is triangulated.
struct WindowTrack {
  uint64_t track_id = 0;
  std::vector<WindowSight> sights;  // By time.
  std::optional<MapLandmark> map_landmark;
  bool is_triangulated = false;
  Eigen::Vector3d x_in_local = Eigen::Vector3d::Zero();
};

// Not thread-safe. Tracks stay where they are in memory until they are dropped; their storage is
// used again.
class WindowTracks {
 public:
  WindowTracks(const Camera& camera, const Rig& rig) : camera_(camera), rig_(rig) {}

  // Enters the features of a camera; those that cannot be unprojected are left out.
  void AddFeatures(WindowCamera* camera, std::span<const TrackedFeature> features);

  // Nothing if no camera of the window sees it.
  WindowTrack* Find(uint64_t track_id);

  // Calls visit(WindowTrack*) in order of first sight.
  template <typename Visitor>
  void ForEach(const Visitor& visit) {
    for (WindowTrack& track : tracks_) {
      if (!track.sights.empty()) {
        visit(&track);
      }
    }
  }

  // Forgets what a camera saw.
  void DropCamera(const WindowCamera* camera);
  // Empties a track; the next sight begins a new one.
  void Forget(WindowTrack* track);

  // Sets the point of a local track of at least two sights. False, with nothing changed, if it
  // cannot be found.
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
