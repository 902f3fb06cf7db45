#include "lab/rivals/fusion/window_tracks.h"

#include <algorithm>

namespace cairn::fusion {

WindowTrack* WindowTracks::FindOrAdd(uint64_t track_id) {
  const auto [it, is_new] = index_.try_emplace(track_id, nullptr);
  if (is_new) {
    if (free_.empty()) {
      free_.push_back(&tracks_.emplace_back());
    }
    it->second = free_.back();
    free_.pop_back();
    it->second->track_id = track_id;
  }
  return it->second;
}

void WindowTracks::AddFeatures(WindowCamera* camera, std::span<const TrackedFeature> features) {
  for (const TrackedFeature& feature : features) {
    const auto ray = camera_.Unproject(feature.pixel);
    if (ray && ray->z() > 0.0) {
      FindOrAdd(feature.track_id)
          ->observations.push_back({camera, feature.pixel, ray->head<2>() / ray->z()});
    }
  }
}

WindowTrack* WindowTracks::Find(uint64_t track_id) {
  const auto it = index_.find(track_id);
  return it == index_.end() ? nullptr : it->second;
}

void WindowTracks::DropCamera(const WindowCamera* camera) {
  ForEach([&](WindowTrack* track) {
    std::erase_if(track->observations, [&](const WindowObservation& observation) {
      return observation.camera == camera;
    });
    if (track->observations.empty()) {
      Forget(track);
    }
  });
}

void WindowTracks::Forget(WindowTrack* track) {
  index_.erase(track->track_id);
  track->observations.clear();
  track->map_landmark.reset();
  track->is_triangulated = false;
  free_.push_back(track);
}

bool WindowTracks::TriangulateTrack(double sigma_px, const TriangulateOptions& options,
                                    WindowTrack* track) {
  std::vector<CameraView> views;
  std::vector<PosedObservation> observations;
  views.reserve(track->observations.size());
  for (const WindowObservation& observation : track->observations) {
    Clone clone;
    clone.local_from_imu = observation.camera->State().local_from_imu;
    views.emplace_back(rig_, clone);
    observations.push_back(
        {&views.back(), observation.pixel, observation.normalized.homogeneous().normalized()});
  }
  const auto point = Triangulate(camera_, observations, sigma_px, options);
  if (point) {
    track->x_in_local = *point;
    track->is_triangulated = true;
  }
  return point.has_value();
}

}  // namespace cairn::fusion
