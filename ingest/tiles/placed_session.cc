#include "ingest/tiles/placed_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/error.h"
#include "core/geodesy.h"
#include "core/printable.h"
#include "core/scene/triangulate.h"
#include "storage/tile/tile.h"

namespace cairn {
namespace {

// A tile's frame reaches 4,096 m from its anchor, which lies at height 0: beyond these bounds a
// camera or what it sees could not be written.
constexpr double kMaxCameraHeightM = 4000.0;
constexpr double kMaxLandmarkHeightM = 4080.0;
// What is so far from a camera that sees it is no landmark: it hardly moves as the camera does.
constexpr double kMaxViewDistanceM = 2000.0;

void ValidateSimilarity(const Sim3d& ecef_from_world) {
  const bool usable = std::isfinite(ecef_from_world.scale) && ecef_from_world.scale > 0.0 &&
                      ecef_from_world.translation.allFinite() &&
                      std::abs(ecef_from_world.rotation.norm() - 1.0) < 1e-6;
  if (!usable) {
    throw Error(ErrorCode::kBadInput,
                "the similarity that places the reconstruction on Earth is not finite");
  }
}

TileId TileOfCamera(const std::string& image_name, const Rigid3d& cam_from_ecef) {
  const Geodetic position = GeodeticFromEcef(cam_from_ecef.Inverse().translation);
  if (!(std::abs(position.h_m) <= kMaxCameraHeightM)) {
    throw Error(
        ErrorCode::kBadInput,
        fmt::format("image {} would stand {:.0f} m above the ellipsoid; maps reach from "
                    "-{:.0f} to {:.0f} m; check the georegistration",
                    Excerpt(image_name), position.h_m, kMaxCameraHeightM, kMaxCameraHeightM));
  }
  return TileId::Containing(position);
}

// The landmark on Earth, or nothing if it should be dropped.
class LandmarkJudge {
 public:
  LandmarkJudge(const Reconstruction& reconstruction, const Sim3d& ecef_from_world,
                const PlacementOptions& options)
      : reconstruction_(reconstruction), ecef_from_world_(ecef_from_world), options_(options) {}

  std::optional<PlacedLandmark> Place(uint32_t recon_idx) const {
    const ReconLandmark& landmark = reconstruction_.landmarks[recon_idx];
    if (static_cast<int>(landmark.observations.size()) < options_.min_observations) {
      return std::nullopt;
    }
    const std::vector<PointObservation> observations =
        PointObservationsOf(reconstruction_, landmark);
    const auto uncertainty = EstimateUncertainty(observations, landmark.x_in_world);
    if (!uncertainty) {
      return std::nullopt;
    }
    const double sigma_m = ecef_from_world_.scale * uncertainty->Sigma();
    const bool good = sigma_m <= options_.max_sigma_m &&
                      uncertainty->median_error_px <= options_.max_reprojection_error_px &&
                      IsNear(observations, landmark.x_in_world);
    if (!good) {
      return std::nullopt;
    }
    const Eigen::Vector3d x_in_ecef = ecef_from_world_ * landmark.x_in_world;
    if (std::abs(GeodeticFromEcef(x_in_ecef).h_m) > kMaxLandmarkHeightM) {
      return std::nullopt;
    }
    return PlacedLandmark{recon_idx, x_in_ecef, sigma_m,
                          static_cast<uint32_t>(landmark.observations.size())};
  }

 private:
  bool IsNear(const std::vector<PointObservation>& observations,
              const Eigen::Vector3d& x_in_world) const {
    return std::all_of(
        observations.begin(), observations.end(), [&](const PointObservation& observation) {
          return ecef_from_world_.scale * (observation.cam_from_world * x_in_world).norm() <
                 kMaxViewDistanceM;
        });
  }

  const Reconstruction& reconstruction_;
  const Sim3d& ecef_from_world_;
  const PlacementOptions& options_;
};

// Sorts by the Morton code of positions, shrunk into the range that such codes cover.
void SortInSpace(std::vector<PlacedLandmark>* landmarks) {
  constexpr double kMaxCoordinateM = 4000.0;
  const Eigen::Vector3d origin_in_ecef = landmarks->front().x_in_ecef;
  double extent_m = 1.0;
  for (const PlacedLandmark& landmark : *landmarks) {
    extent_m = std::max(extent_m, (landmark.x_in_ecef - origin_in_ecef).cwiseAbs().maxCoeff());
  }
  const double shrink = std::min(1.0, kMaxCoordinateM / extent_m);
  std::vector<Eigen::Vector3f> positions;
  positions.reserve(landmarks->size());
  for (const PlacedLandmark& landmark : *landmarks) {
    positions.push_back(QuantizePosition(shrink * (landmark.x_in_ecef - origin_in_ecef)));
  }
  std::vector<PlacedLandmark> sorted;
  sorted.reserve(landmarks->size());
  for (const uint32_t i : MortonOrder(positions)) {
    sorted.push_back((*landmarks)[i]);
  }
  *landmarks = std::move(sorted);
}

}  // namespace

std::vector<int> KeypointsOf(std::span<const PlacedObservation> observations) {
  std::vector<int> keypoints(observations.size());
  std::ranges::transform(observations, keypoints.begin(), &PlacedObservation::keypoint_idx);
  return keypoints;
}

PlacedSession PlaceSession(const Reconstruction& reconstruction, const Sim3d& ecef_from_world,
                           const PlacementOptions& options) {
  ValidateSimilarity(ecef_from_world);
  PlacedSession session;
  for (const ReconImage& image : reconstruction.images) {
    session.cam_from_ecef.push_back(CamFromTarget(image.cam_from_world, ecef_from_world));
    TileOfCamera(image.name, session.cam_from_ecef.back());  // Throws if there is none.
  }

  const LandmarkJudge judge(reconstruction, ecef_from_world, options);
  for (uint32_t i = 0; i < reconstruction.landmarks.size(); ++i) {
    if (const auto landmark = judge.Place(i)) {
      session.landmarks.push_back(*landmark);
    }
  }
  if (session.landmarks.empty()) {
    throw Error(ErrorCode::kBadInput,
                fmt::format("none of the {} landmarks can be kept: they have fewer than {} "
                            "observations, a position uncertain by more than {} m or reprojection "
                            "errors above {} px",
                            reconstruction.landmarks.size(), options.min_observations,
                            options.max_sigma_m, options.max_reprojection_error_px));
  }
  SortInSpace(&session.landmarks);

  session.observations_of_image.resize(reconstruction.images.size());
  for (uint32_t i = 0; i < session.landmarks.size(); ++i) {
    for (const auto& observation :
         reconstruction.landmarks[session.landmarks[i].recon_idx].observations) {
      session.observations_of_image[observation.image_idx].push_back({i, observation.keypoint_idx});
    }
  }
  AssignTiles(reconstruction, &session);
  return session;
}

void AssignTiles(const Reconstruction& reconstruction, PlacedSession* session) {
  session->images_of_tile.clear();
  for (size_t image_idx = 0; image_idx < reconstruction.images.size(); ++image_idx) {
    if (session->observations_of_image[image_idx].empty()) {
      continue;
    }
    const TileId tile_id =
        TileOfCamera(reconstruction.images[image_idx].name, session->cam_from_ecef[image_idx]);
    session->images_of_tile[tile_id].push_back(static_cast<int>(image_idx));
  }
}

}  // namespace cairn
