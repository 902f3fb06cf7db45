#include "ingest/adjust_session.h"

#include <algorithm>
#include <span>

#include "core/error.h"
#include "core/geodesy.h"
#include "core/parallel_for.h"
#include "core/scene/triangulate.h"

namespace cairn {
namespace {

constexpr int kLeastKnownLandmarks = 20;

// The session as placed, without descriptors, in a frame of short coordinates.
Reconstruction ModelOf(const Reconstruction& reconstruction, const PlacedSession& session,
                       const std::vector<std::optional<Eigen::Vector3d>>& known_in_ecef,
                       const Rigid3d& enu_from_ecef) {
  Reconstruction model;
  model.cameras = reconstruction.cameras;
  const Rigid3d ecef_from_enu = enu_from_ecef.Inverse();
  for (size_t i = 0; i < reconstruction.images.size(); ++i) {
    ReconImage& image = model.images.emplace_back();
    image.camera_idx = reconstruction.images[i].camera_idx;
    image.cam_from_world = session.cam_from_ecef[i] * ecef_from_enu;
    image.features.keypoints = reconstruction.images[i].features.keypoints;
  }
  for (size_t i = 0; i < session.landmarks.size(); ++i) {
    const PlacedLandmark& landmark = session.landmarks[i];
    model.landmarks.push_back({enu_from_ecef * known_in_ecef[i].value_or(landmark.x_in_ecef),
                               reconstruction.landmarks[landmark.recon_idx].observations});
  }
  return model;
}

// Nothing if the solver fails.
std::optional<AdjustReport> AdjustIfSolved(const AdjustPriors& priors, const AdjustOptions& options,
                                           const AdjustProgress& progress, Reconstruction* model) {
  const std::vector<CameraFreedom> freedoms(model->cameras.size(), CameraFreedom::kFixed);
  try {
    return Adjust(freedoms, priors, options, *model, progress);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kInternal) {
      throw;
    }
    return std::nullopt;
  }
}

// Where the landmark stands by the adjusted cameras; where they carry it if its rays do not tell.
Eigen::Vector3d Placed(const Reconstruction& before, const Reconstruction& adjusted,
                       const ReconLandmark& landmark) {
  if (const auto x_in_world = TriangulatePoint(PointObservationsOf(adjusted, landmark))) {
    return *x_in_world;
  }
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const ReconObservation& seen : landmark.observations) {
    const auto image = static_cast<size_t>(seen.image_idx);
    sum += adjusted.images[image].cam_from_world.Inverse() *
           (before.images[image].cam_from_world * landmark.x_in_world);
  }
  return sum / static_cast<double>(landmark.observations.size());
}

}  // namespace

JointAdjustment AdjustSession(const Reconstruction& reconstruction,
                              const std::vector<std::optional<Eigen::Vector3d>>& known_in_ecef,
                              int num_threads, PlacedSession* session,
                              const AdjustProgress& progress) {
  JointAdjustment joint;
  AdjustPriors priors;
  for (const auto& known : known_in_ecef) {
    priors.landmark_is_fixed.push_back(known ? 1 : 0);
    joint.num_shared += known ? 1 : 0;
  }
  if (joint.num_shared < kLeastKnownLandmarks) {
    return {};
  }
  const Rigid3d enu_from_ecef =
      EcefFromEnu(GeodeticFromEcef(session->cam_from_ecef.front().Inverse().translation)).Inverse();
  const Reconstruction before = ModelOf(reconstruction, *session, known_in_ecef, enu_from_ecef);
  Reconstruction model = before;
  AdjustOptions options;
  options.num_threads = num_threads;
  const std::optional<AdjustReport> report = AdjustIfSolved(priors, options, progress, &model);
  if (!report) {
    return {};
  }
  joint.num_observations = report->num_observations;
  joint.rms_px = report->rms_px;
  const Rigid3d ecef_from_enu = enu_from_ecef.Inverse();
  for (size_t i = 0; i < model.images.size(); ++i) {
    const Eigen::Vector3d moved_m = model.images[i].cam_from_world.Inverse().translation -
                                    before.images[i].cam_from_world.Inverse().translation;
    joint.largest_move_m = std::max(joint.largest_move_m, moved_m.norm());
    session->cam_from_ecef[i] = model.images[i].cam_from_world * enu_from_ecef;
  }
  ParallelFor(static_cast<int>(session->landmarks.size()), num_threads, [&](int i) {
    const auto idx = static_cast<size_t>(i);
    session->landmarks[idx].x_in_ecef =
        ecef_from_enu * Placed(before, model, before.landmarks[idx]);
  });
  return joint;
}

}  // namespace cairn
