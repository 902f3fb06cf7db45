#include "ingest/place/in_map_accuracy.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/evenly_of.h"
#include "core/radius68.h"
#include "core/scene/triangulate.h"
#include "engine/pose/refine_pose.h"

namespace cairn {
namespace {

constexpr size_t kMaxPhotos = 40, kMinPhotos = 5;
constexpr size_t kMaxLandmarks = 400, kMinLandmarks = 24;
// Factor on radii that are predicted from landmarks whose errors are as large along each axis, as
// here. Answers know the shapes of the errors, and have another (docs/decisions/0080).
constexpr double kRoundErrors = 1.35;

// The landmark of an observation as the other photos see it, in meters of the world frame.
std::optional<PoseObservation> WithoutPhoto(const Reconstruction& reconstruction,
                                            const ReconLandmark& landmark, int image_idx,
                                            double scale) {
  ReconLandmark others;
  std::optional<Eigen::Vector2d> pixel;
  for (const ReconObservation& observation : landmark.observations) {
    if (observation.image_idx != image_idx) {
      others.observations.push_back(observation);
      continue;
    }
    const Keypoint& keypoint =
        reconstruction.images[image_idx].features.keypoints[observation.keypoint_idx];
    pixel = Eigen::Vector2d(keypoint.x_px, keypoint.y_px);
  }
  const std::vector<PointObservation> observations = PointObservationsOf(reconstruction, others);
  const auto x_in_world = TriangulatePoint(observations);
  const auto uncertainty =
      x_in_world ? EstimateUncertainty(observations, *x_in_world) : std::nullopt;
  if (!pixel || !uncertainty) {
    return std::nullopt;
  }
  return PoseObservation{*pixel, scale * *x_in_world, scale * uncertainty->Sigma()};
}

// The landmarks that a photo sees, as the other photos see them.
std::vector<PoseObservation> SeenByOthers(const Reconstruction& reconstruction,
                                          const PlacedSession& session, int image_idx,
                                          double scale) {
  std::vector<const ReconLandmark*> seen;
  for (const PlacedObservation& observation : session.observations_of_image[image_idx]) {
    const ReconLandmark& landmark =
        reconstruction.landmarks[session.landmarks[observation.landmark_idx].recon_idx];
    if (landmark.observations.size() >= 3) {
      seen.push_back(&landmark);
    }
  }
  std::vector<PoseObservation> observations;
  for (const ReconLandmark* landmark : EvenlyOf(std::move(seen), kMaxLandmarks)) {
    if (auto observation = WithoutPhoto(reconstruction, *landmark, image_idx, scale)) {
      observations.push_back(*observation);
    }
  }
  return observations;
}

// A photo with its pose in meters of the world frame.
struct PosedPhoto {
  const Camera& camera;
  Rigid3d cam_from_world;

  // Where the photo stands by these landmarks.
  PhotoDisagreement By(const std::vector<PoseObservation>& observations) const {
    const RefinedPose refined = RefinePose(camera, observations, {}, cam_from_world, {});
    const auto covariance = PoseCovariance(camera, observations, {}, refined.cam_from_anchor, {});
    const Eigen::Vector3d moved_m =
        refined.cam_from_anchor.Inverse().translation - cam_from_world.Inverse().translation;
    return {moved_m.norm(), kRoundErrors * Radius68(covariance.bottomRightCorner<3, 3>())};
  }
};

// Splits observations at the median of a number that each has.
template <typename Number>
std::array<std::vector<PoseObservation>, 2> Halves(std::vector<PoseObservation> observations,
                                                   const Number& number) {
  const auto middle = observations.begin() + static_cast<std::ptrdiff_t>(observations.size() / 2);
  std::nth_element(observations.begin(), middle, observations.end(),
                   [&](const auto& a, const auto& b) { return number(a) < number(b); });
  return {std::vector<PoseObservation>(observations.begin(), middle),
          std::vector<PoseObservation>(middle, observations.end())};
}

// Appends how far off a photo is by the landmarks on the left of the image, on the right, near and
// far. The photo's own pose follows from all of its landmarks, so that it agrees with them; a query
// matches some, in another distribution. Errors by all landmarks would be smaller than by a half:
// as the predicted radius is, if the errors of parts of the map are independent, or not at all, if
// they are alike. The square root stands between the two.
void AppendDisagreements(const PosedPhoto& photo, const std::vector<PoseObservation>& observations,
                         std::vector<PhotoDisagreement>* disagreements) {
  const double predicted_m = photo.By(observations).predicted_m;
  const auto x_px = [](const PoseObservation& observation) { return observation.pixel.x(); };
  const auto depth_m = [&](const PoseObservation& observation) {
    return (photo.cam_from_world * observation.x_in_anchor).z();
  };
  for (const auto& halves : {Halves(observations, x_px), Halves(observations, depth_m)}) {
    for (const std::vector<PoseObservation>& half : halves) {
      const PhotoDisagreement by_half = photo.By(half);
      const double shrinkage = std::sqrt(std::min(1.0, predicted_m / by_half.predicted_m));
      disagreements->push_back({shrinkage * by_half.error_m, shrinkage * by_half.predicted_m});
    }
  }
}

}  // namespace

double UnpredictedRadius68(const std::vector<PhotoDisagreement>& photos) {
  if (photos.empty()) {
    return 0.0;
  }
  std::vector<double> rests_m;
  for (const PhotoDisagreement& photo : photos) {
    const double sq_rest = photo.error_m * photo.error_m - photo.predicted_m * photo.predicted_m;
    rests_m.push_back(std::sqrt(std::max(sq_rest, 0.0)));
  }
  const auto rank =
      std::min(rests_m.size() - 1, static_cast<size_t>(0.68 * static_cast<double>(rests_m.size())));
  std::nth_element(rests_m.begin(), rests_m.begin() + static_cast<std::ptrdiff_t>(rank),
                   rests_m.end());
  return rests_m[rank];
}

std::optional<double> EstimateInMapAccuracy(const Reconstruction& reconstruction,
                                            const PlacedSession& session, double scale) {
  std::vector<int> images;
  for (size_t i = 0; i < session.observations_of_image.size(); ++i) {
    if (session.observations_of_image[i].size() >= kMinLandmarks) {
      images.push_back(static_cast<int>(i));
    }
  }
  std::vector<PhotoDisagreement> disagreements;
  size_t num_photos = 0;
  for (const int image_idx : EvenlyOf(std::move(images), kMaxPhotos)) {
    const ReconImage& image = reconstruction.images[image_idx];
    const std::vector<PoseObservation> observations =
        SeenByOthers(reconstruction, session, image_idx, scale);
    if (observations.size() >= kMinLandmarks) {
      const Rigid3d cam_from_world(image.cam_from_world.rotation,
                                   scale * image.cam_from_world.translation);
      AppendDisagreements({reconstruction.cameras[image.camera_idx], cam_from_world}, observations,
                          &disagreements);
      ++num_photos;
    }
  }
  return num_photos < kMinPhotos ? std::nullopt : std::optional(UnpredictedRadius68(disagreements));
}

}  // namespace cairn
