#include "mapping/session/place_segment.h"

#include <fmt/format.h>

#include <limits>
#include <utility>

#include "core/error.h"
#include "core/radius68.h"
#include "mapping/growth/camera_freedom.h"

namespace cairn {
namespace {

constexpr int kMinPlaced = 3;
// A position that says nothing about its height.
constexpr double kUnknownHeightSigmaM = 1e6;

std::vector<CameraPosition> PositionsOf(const PhotoPlaces& places, const Segment& segment) {
  std::vector<CameraPosition> positions;
  for (const int photo : segment.photo_of_image) {
    if (places.positions[photo]) {
      positions.push_back(*places.positions[photo]);
    }
  }
  return positions;
}

Georegistration Register(const PhotoPlaces& places, const Segment& segment,
                         const GeoregisterOptions& options) {
  const std::vector<CameraPosition> positions = PositionsOf(places, segment);
  if (static_cast<int>(positions.size()) < kMinPlaced) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("{} of its {} photos have a position on Earth, and {} are needed",
                            positions.size(), segment.photo_of_image.size(), kMinPlaced));
  }
  ImageOrientations orientations;
  for (const int photo : segment.photo_of_image) {
    orientations.push_back(places.orientations[photo]);
  }
  return Georegister(segment.model, positions, options, orientations);
}

void Move(const Sim3d& target_from_world, Reconstruction* model) {
  for (ReconImage& image : model->images) {
    image.cam_from_world = CamFromTarget(image.cam_from_world, target_from_world);
  }
  for (ReconLandmark& landmark : model->landmarks) {
    landmark.x_in_world = target_from_world * landmark.x_in_world;
  }
}

// The middle of the cameras.
Geodetic OriginOf(const Reconstruction& model, const Sim3d& ecef_from_world) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const ReconImage& image : model.images) {
    sum += image.cam_from_world.Inverse().translation;
  }
  return GeodeticFromEcef(ecef_from_world * (sum / static_cast<double>(model.images.size())));
}

// The positions count as if their accuracy were `slack` times as large.
AdjustPriors PriorsOf(const PhotoSet& set, const PhotoPlaces& places, const Segment& segment,
                      const Rigid3d& enu_from_ecef, double slack) {
  AdjustPriors priors;
  for (const int photo : segment.photo_of_image) {
    std::optional<CenterPrior> prior;
    if (const auto& position = places.positions[photo]) {
      const double accuracy_m = slack * position->accuracy_m;
      const double sigma_m = accuracy_m / kRadius68PerSigma2d;
      prior =
          CenterPrior{enu_from_ecef * EcefFromGeodetic(position->position),
                      {sigma_m, sigma_m, position->has_height ? accuracy_m : kUnknownHeightSigmaM}};
    }
    priors.position_of_image.push_back(prior);
  }
  for (const MappingCamera& camera : set.cameras) {
    const bool is_known = camera.source == FocalSource::kCalibration;
    priors.focal_sigma_of_camera.push_back(is_known ? 0.0 : camera.focal.log_sigma);
    priors.camera_means.push_back(camera.camera);
  }
  return priors;
}

// For each camera of the set.
std::vector<CameraFreedom> FreedomsOf(const PhotoSet& set, const Reconstruction& model) {
  std::vector<int> num_photos(set.cameras.size(), 0);
  for (const ReconImage& image : model.images) {
    ++num_photos[image.camera_idx];
  }
  std::vector<CameraFreedom> freedom;
  for (size_t i = 0; i < set.cameras.size(); ++i) {
    freedom.push_back(HasFocalOfExif(set.cameras[i], model.cameras[i])
                          ? CameraFreedom::kFixed
                          : FreedomOf(set.cameras[i], num_photos[i], /*is_final=*/true));
  }
  return freedom;
}

}  // namespace

AdjustedSegment AdjustToPositions(const PhotoSet& set, const PhotoPlaces& places, Segment segment,
                                  const GeoregisterOptions& options, const AdjustOptions& adjust,
                                  const AdjustProgress& progress) {
  // A segment bends as it grows, by more than good positions err. The adjustment straightens it, so
  // only then its residuals tell whether it belongs there.
  GeoregisterOptions bent = options;
  bent.max_median_residual_sigmas = std::numeric_limits<double>::infinity();
  const Georegistration start = Register(places, segment, bent);
  const Geodetic origin = OriginOf(segment.model, start.ecef_from_world);
  const Rigid3d enu_from_ecef = EcefFromEnu(origin).Inverse();
  Move(enu_from_ecef * start.ecef_from_world, &segment.model);
  const std::vector<CameraFreedom> freedom = FreedomsOf(set, segment.model);
  // The loss would take positions far beyond their accuracy for outliers.
  const double slack = start.median_residual_m / start.stated_accuracy_m;
  if (slack > 1.0) {
    Adjust(freedom, PriorsOf(set, places, segment, enu_from_ecef, slack), adjust, segment.model,
           progress);
  }
  const AdjustReport report = Adjust(freedom, PriorsOf(set, places, segment, enu_from_ecef, 1.0),
                                     adjust, segment.model, progress);
  return {std::move(segment), origin, report};
}

PlacedSegment PlaceSegment(const PhotoPlaces& places, AdjustedSegment adjusted,
                           const GeoregisterOptions& options) {
  PlacedSegment placed;
  placed.adjustment = adjusted.report;
  placed.segment = std::move(adjusted.segment);
  placed.georegistration = Register(places, placed.segment, options);
  const Rigid3d ecef_from_enu = EcefFromEnu(adjusted.origin);
  Move(ecef_from_enu.Inverse() * placed.georegistration.ecef_from_world, &placed.segment.model);
  placed.georegistration.ecef_from_world = {1.0, ecef_from_enu.rotation, ecef_from_enu.translation};
  return placed;
}

void TakeWorst(const Georegistration& segment, Georegistration* all) {
  const auto take = [](double of_segment, double* worst) { *worst = std::max(*worst, of_segment); };
  take(segment.accuracy.position_m, &all->accuracy.position_m);
  take(segment.accuracy.rotation_rad, &all->accuracy.rotation_rad);
  take(segment.stated_accuracy_m, &all->stated_accuracy_m);
  take(segment.median_residual_m, &all->median_residual_m);
}

}  // namespace cairn
