#include "cli/demo/street/reconstruct_known_poses.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>

#include "cli/demo/street/guided_matching.h"
#include "cli/demo/street/neighbor_pairs.h"
#include "cli/demo/street/posed_features.h"
#include "core/parallel_for.h"
#include "core/require.h"
#include "core/scene/tracks.h"
#include "core/scene/triangulate.h"

namespace cairn {
namespace {

// Smallest allowed value of the widest angle between two rays of a landmark.
constexpr double kMinAngleRad = 0.035;

// A ParallelFor that reports each finished step.
void RunPhase(const char* phase, int count, int num_threads, const KnownPoseProgress& progress,
              const std::function<void(int)>& step) {
  std::mutex mutex;
  int num_done = 0;
  ParallelFor(count, num_threads, [&](int i) {
    step(i);
    const std::lock_guard<std::mutex> lock(mutex);
    ++num_done;
    if (progress) {
      progress(phase, num_done, count);
    }
  });
}

std::vector<ReconImage> ExtractImages(const std::vector<StreetPhoto>& photos,
                                      const KnownPoseOptions& options,
                                      const KnownPoseProgress& progress) {
  std::vector<ReconImage> images(photos.size());
  RunPhase("features", static_cast<int>(photos.size()), options.num_threads, progress, [&](int i) {
    images[i].name = photos[i].name;
    images[i].cam_from_world = photos[i].cam_from_enu;
    images[i].gps = photos[i].gps;
    images[i].features = ExtractSift(photos[i].image, options.sift);
  });
  return images;
}

std::vector<PairMatches> MatchNeighbors(const std::vector<PosedFeatures>& posed,
                                        const KnownPoseOptions& options,
                                        const KnownPoseProgress& progress) {
  const std::vector<std::pair<int, int>> pairs = FindNeighborPairs(posed);
  std::vector<PairMatches> matches(pairs.size());
  RunPhase("matching", static_cast<int>(pairs.size()), options.num_threads, progress, [&](int i) {
    const auto& [a, b] = pairs[i];
    matches[i] = {a, b, MatchAlongEpipolarLines(posed[a], posed[b])};
  });
  return matches;
}

double WidestAngleRad(const std::vector<PointObservation>& observations,
                      const Eigen::Vector3d& x_in_world) {
  std::vector<Eigen::Vector3d> rays;
  for (const PointObservation& observation : observations) {
    rays.push_back((x_in_world - observation.cam_from_world.Inverse().translation).normalized());
  }
  double min_cos = 1.0;
  for (size_t i = 0; i < rays.size(); ++i) {
    for (size_t j = i + 1; j < rays.size(); ++j) {
      min_cos = std::min(min_cos, rays[i].dot(rays[j]));
    }
  }
  return std::acos(std::max(min_cos, -1.0));
}

// Triangulates a track without the observations that do not fit. Returns nullopt if too few
// observations are left or their angle is too narrow.
std::optional<ReconLandmark> TriangulateTrack(const Reconstruction& reconstruction,
                                              std::vector<ReconObservation> track) {
  ReconLandmark landmark;
  landmark.observations = std::move(track);
  while (static_cast<int>(landmark.observations.size()) >= kMinKnownPoseObservations) {
    const std::vector<PointObservation> observations =
        PointObservationsOf(reconstruction, landmark);
    const auto x_in_world = TriangulatePoint(observations);
    if (!x_in_world) {
      return std::nullopt;
    }
    std::vector<ReconObservation> fitting;
    for (size_t i = 0; i < observations.size(); ++i) {
      const auto pixel =
          observations[i].camera->Project(observations[i].cam_from_world * *x_in_world);
      if (pixel && (*pixel - observations[i].pixel).norm() <= kMaxKnownPoseErrorPx) {
        fitting.push_back(landmark.observations[i]);
      }
    }
    if (fitting.size() == observations.size()) {
      landmark.x_in_world = *x_in_world;
      return WidestAngleRad(observations, *x_in_world) >= kMinAngleRad
                 ? std::optional(std::move(landmark))
                 : std::nullopt;
    }
    landmark.observations = std::move(fitting);
  }
  return std::nullopt;
}

std::vector<ReconLandmark> TriangulateTracks(
    const Reconstruction& reconstruction, const std::vector<std::vector<ReconObservation>>& tracks,
    const KnownPoseOptions& options, const KnownPoseProgress& progress) {
  constexpr int kTracksPerStep = 256;
  const int num_tracks = static_cast<int>(tracks.size());
  const int num_steps = (num_tracks + kTracksPerStep - 1) / kTracksPerStep;
  std::vector<std::vector<ReconLandmark>> landmarks_of_step(num_steps);
  RunPhase("landmarks", num_steps, options.num_threads, progress, [&](int step) {
    const int end = std::min(num_tracks, (step + 1) * kTracksPerStep);
    for (int i = step * kTracksPerStep; i < end; ++i) {
      if (auto landmark = TriangulateTrack(reconstruction, tracks[i])) {
        landmarks_of_step[step].push_back(std::move(*landmark));
      }
    }
  });
  std::vector<ReconLandmark> landmarks;
  for (std::vector<ReconLandmark>& some : landmarks_of_step) {
    std::move(some.begin(), some.end(), std::back_inserter(landmarks));
  }
  return landmarks;
}

}  // namespace

void KnownPoseOptions::Validate() const {
  sift.Validate();
  RequireOption(num_threads >= 1, "known_poses.num_threads must be at least 1");
}

Reconstruction ReconstructWithKnownPoses(const Camera& camera,
                                         const std::vector<StreetPhoto>& photos,
                                         const KnownPoseOptions& options,
                                         const KnownPoseProgress& progress) {
  options.Validate();
  Reconstruction reconstruction;
  reconstruction.cameras = {camera};
  reconstruction.images = ExtractImages(photos, options, progress);
  std::deque<FeatureSet> features;  // `posed` points to them.
  std::vector<PosedFeatures> posed;
  std::vector<int> num_keypoints;
  for (const ReconImage& image : reconstruction.images) {
    features.push_back(image.features.Unpacked());
    posed.push_back(MakePosedFeatures(camera, features.back(), image.cam_from_world));
    num_keypoints.push_back(image.features.size());
  }
  const auto tracks = BuildTracks(MatchNeighbors(posed, options, progress), num_keypoints,
                                  kMinKnownPoseObservations);
  reconstruction.landmarks = TriangulateTracks(reconstruction, tracks, options, progress);
  return reconstruction;
}

}  // namespace cairn
