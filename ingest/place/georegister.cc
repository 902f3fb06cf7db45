#include "ingest/place/georegister.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>

#include "core/error.h"
#include "core/printable.h"
#include "core/radius68.h"
#include "core/require.h"
#include "core/statistics.h"
#include "ingest/place/level_cameras.h"
#include "ingest/place/similarity_problem.h"

namespace cairn {
namespace {

// Fewer positions do not determine a similarity.
constexpr int kMinPositions = 3;

// Positions must spread so far that their errors change the scale by at most this share.
constexpr double kMaxRelativeScaleError = 0.25;

Eigen::Vector3d CenterInWorld(const ReconImage& image) {
  return image.cam_from_world.Inverse().translation;
}

struct MatchedPosition {
  std::string image_name;
  Geodetic position;
  Eigen::Vector3d center_in_world;
  Eigen::Vector3d center_in_ecef;
  double accuracy_m = 0.0;
  double height_accuracy_m = 0.0;
};

// A position without a height says nothing about heights.
constexpr double kUnknownHeightM = 1e6;

std::vector<MatchedPosition> MatchByName(const Reconstruction& reconstruction,
                                         const std::vector<CameraPosition>& positions) {
  std::unordered_map<std::string, const ReconImage*> image_of_name;
  for (const ReconImage& image : reconstruction.images) {
    image_of_name.emplace(image.name, &image);
  }
  std::vector<MatchedPosition> matched;
  for (const CameraPosition& position : positions) {
    const auto image = image_of_name.find(position.image_name);
    if (image == image_of_name.end()) {
      continue;
    }
    ValidateGeodetic(position.position, position.image_name.c_str());
    if (!(position.accuracy_m > 0.0) || !std::isfinite(position.accuracy_m)) {
      throw Error(ErrorCode::kBadInput,
                  fmt::format("the accuracy of {} must be positive", Excerpt(position.image_name)));
    }
    matched.push_back({position.image_name, position.position, CenterInWorld(*image->second),
                       EcefFromGeodetic(position.position), position.accuracy_m,
                       position.has_height ? position.accuracy_m : kUnknownHeightM});
  }
  return matched;
}

// A frame centered on the cameras in which their spread is about one, so that the solver sees
// well-scaled numbers in any units of the reconstruction.
Sim3d NormalizedFromWorld(const std::vector<MatchedPosition>& matched) {
  std::vector<Eigen::Vector3d> centers;
  for (const MatchedPosition& position : matched) {
    centers.push_back(position.center_in_world);
  }
  const Eigen::Vector3d middle = MedianPoint(centers);
  std::vector<double> distances;
  for (const Eigen::Vector3d& center : centers) {
    distances.push_back((center - middle).norm());
  }
  const double spread = Median(distances);
  if (!(spread > 0.0)) {
    throw Error(ErrorCode::kBadInput,
                "georegistration: the cameras with known positions are all at one place of the "
                "reconstruction and determine no similarity");
  }
  return {1.0 / spread, Eigen::Quaterniond::Identity(), -middle / spread};
}

std::vector<SimilarityProblem::Position> PositionsInEnu(const std::vector<MatchedPosition>& matched,
                                                        const Sim3d& normalized_from_world,
                                                        const Rigid3d& ecef_from_enu) {
  const Rigid3d enu_from_ecef = ecef_from_enu.Inverse();
  std::vector<SimilarityProblem::Position> positions;
  for (const MatchedPosition& position : matched) {
    positions.push_back({normalized_from_world * position.center_in_world,
                         enu_from_ecef * position.center_in_ecef, position.accuracy_m,
                         position.height_accuracy_m});
  }
  return positions;
}

// Adds the prior that cameras are held level.
void AddLevelCameras(const Reconstruction& reconstruction, const ImageOrientations& orientations,
                     double normalized_per_world, const GeoregisterOptions& options,
                     SimilarityProblem* problem, UpReport* report) {
  if (options.upright_sigma_rad == 0.0 || options.up == UpSource::kPositions) {
    report->source = "the positions alone";
    return;
  }
  const CameraHolds holds = FindCameraHolds(reconstruction, orientations, problem->positions,
                                            normalized_per_world, options);
  problem->upright_sigma_rad = options.upright_sigma_rad;
  problem->up_in_world = holds.up_in_world;
  for (size_t i = 0; i < holds.of_image.size(); ++i) {
    const Eigen::Quaterniond world_from_cam =
        reconstruction.images[i].cam_from_world.rotation.conjugate();
    problem->right_in_world.push_back(world_from_cam * LevelInCam(holds.of_image[i]));
    if (holds.of_image[i] == PictureUp::kBack) {
      // Heights of GPS tell the tilt of a small area worse than its photos do.
      problem->right_in_world.push_back(world_from_cam * Eigen::Vector3d::UnitY());
    }
    problem->mean_up_in_world += world_from_cam * UpInCam(holds.of_image[i]);
  }
  problem->mean_up_in_world /= static_cast<double>(reconstruction.images.size());
  *report = holds.report;
}

// Positions farther away than this many times the median distance do not count for the spread.
constexpr double kMaxMedianDistances = 6.0;

[[noreturn]] void ThrowUnknownScale(size_t num_positions, const std::string& errors,
                                    double spread_m) {
  throw Error(
      ErrorCode::kBadInput,
      fmt::format("georegistration: the {} known positions, {}, spread by only {:.1f} m and "
                  "do not determine the scale; give positions farther apart or more "
                  "accurate ones",
                  num_positions, errors, spread_m));
}

void RequireSpread(const SimilarityProblem& problem) {
  std::vector<Eigen::Vector3d> centers;
  std::vector<double> accuracies_m, distances_m;
  for (const auto& position : problem.positions) {
    centers.push_back(position.center_in_enu);
    accuracies_m.push_back(position.accuracy_m);
  }
  const Eigen::Vector3d middle = MedianPoint(centers);
  for (const Eigen::Vector3d& center : centers) {
    distances_m.push_back((center - middle).norm());
  }
  const double far_m = kMaxMedianDistances * Median(distances_m);
  double sum_sq_m = 0.0;
  for (const double distance_m : distances_m) {
    sum_sq_m += distance_m < far_m ? distance_m * distance_m : 0.0;
  }
  const double accuracy_m = Median(accuracies_m);
  // The standard deviation of a scale that is fitted to n positions with this spread.
  if (!(accuracy_m < kMaxRelativeScaleError * std::sqrt(sum_sq_m))) {
    ThrowUnknownScale(centers.size(), fmt::format("accurate to {:.1f} m", accuracy_m),
                      std::sqrt(sum_sq_m / static_cast<double>(centers.size())));
  }
}

// Errors of positions spread them, too, so RequireSpread holds for any positions that err much more
// than they state. The cameras of the fit spread only as far as they were apart.
void RequireSpreadOfFit(const SimilarityProblem& problem, const Sim3d& enu_from_normalized) {
  std::vector<Eigen::Vector3d> centers;
  std::vector<double> accuracies_m;
  double sum_sq_error_m = 0.0;
  for (const auto& position : problem.positions) {
    const Eigen::Vector3d center = enu_from_normalized * position.center_in_world;
    const double error_m = (center - position.center_in_enu).head<2>().norm();
    if (error_m <= 3.0 * kLossScaleSigmas * position.accuracy_m) {
      centers.push_back(center);
      accuracies_m.push_back(position.accuracy_m);
      sum_sq_error_m += error_m * error_m;
    }
  }
  if (static_cast<int>(centers.size()) < kMinPositions) {
    return;  // Too few to tell.
  }
  const double count = static_cast<double>(centers.size());
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& center : centers) {
    middle += center / count;
  }
  double sum_sq_m = 0.0;
  for (const Eigen::Vector3d& center : centers) {
    sum_sq_m += (center - middle).squaredNorm();
  }
  // Scale, turn and place take four of the errors' degrees of freedom.
  const double shown_m = kRadius68PerSigma2d * std::sqrt(sum_sq_error_m / (2.0 * count - 4.0));
  const double stated_m = Median(accuracies_m);
  if (!(std::max(shown_m, stated_m) < kMaxRelativeScaleError * std::sqrt(sum_sq_m))) {
    ThrowUnknownScale(problem.positions.size(),
                      fmt::format("stated to {:.1f} m and, by the photos, accurate to {:.1f} m",
                                  stated_m, shown_m),
                      std::sqrt(sum_sq_m / count));
  }
}

// Estimates the accuracy of the fit from the positions that agree with it. `matched` are those of
// the problem.
PlacementAccuracy AccuracyOf(const SimilarityProblem& problem,
                             const std::vector<MatchedPosition>& matched,
                             const Sim3d& enu_from_normalized) {
  std::map<std::string, FittedPosition> by_name;
  for (size_t i = 0; i < matched.size(); ++i) {
    const SimilarityProblem::Position& position = problem.positions[i];
    Eigen::Vector3d residual_m =
        enu_from_normalized * position.center_in_world - position.center_in_enu;
    if (position.height_accuracy_m >= kUnknownHeightM) {
      residual_m.z() = 0.0;
    }
    if (residual_m.norm() <= 3.0 * kLossScaleSigmas * position.accuracy_m) {
      by_name[matched[i].image_name] = {position.center_in_enu, residual_m, position.accuracy_m};
    }
  }
  std::vector<FittedPosition> fitted;
  for (const auto& [name, position] : by_name) {
    fitted.push_back(position);
  }
  return EstimatePlacementAccuracy(fitted, problem.upright_sigma_rad);
}

// Whether the position would be within its limits with the other sign of a coordinate.
bool HasLostSign(const MatchedPosition& matched, const Eigen::Vector3d& center_in_ecef) {
  const double limit_m = 3.0 * kLossScaleSigmas * matched.accuracy_m;
  for (const auto& [lat_sign, lon_sign] : {std::pair(-1.0, 1.0), {1.0, -1.0}, {-1.0, -1.0}}) {
    Geodetic other = matched.position;
    other.lat_rad *= lat_sign;
    other.lon_rad *= lon_sign;
    if ((EcefFromGeodetic(other) - center_in_ecef).norm() <= limit_m) {
      return true;
    }
  }
  return false;
}

// Looks at the positions that do not agree, which count for nothing.
void FindFaults(const std::vector<MatchedPosition>& matched, Georegistration* result) {
  for (size_t i = 0; i < matched.size(); ++i) {
    if (result->residuals_m[i] == result->max_residual_m) {
      result->worst_image = matched[i].image_name;
    }
    const bool agrees = result->residuals_m[i] <= 3.0 * kLossScaleSigmas * matched[i].accuracy_m;
    result->num_sign_errors +=
        !agrees && HasLostSign(matched[i], result->ecef_from_world * matched[i].center_in_world);
  }
}

// Errors that rough positions state are no fault: heights err up to three times as much as the
// stated radius, which is horizontal.
constexpr double kMaxStated = 3.0;

double MaxMedianResidualM(const GeoregisterOptions& options, double stated_accuracy_m) {
  const double limit_m = options.max_median_residual_m;
  if (limit_m < GeoregisterOptions{}.max_median_residual_m) {
    return limit_m;  // Somebody asked for less than the default.
  }
  return std::max(limit_m, kMaxStated * stated_accuracy_m);
}

std::string DescribeLimits(const GeoregisterOptions& options, double stated_accuracy_m) {
  const double limit_m = MaxMedianResidualM(options, stated_accuracy_m);
  if (!std::isfinite(options.max_median_residual_sigmas)) {
    return fmt::format("the limit is {:.2f} m", limit_m);
  }
  return fmt::format("the limits are {:.2f} m and {:.1f}", limit_m,
                     options.max_median_residual_sigmas);
}

// Computes the residuals and refuses a bad fit.
void Judge(const SimilarityProblem& problem, const Sim3d& enu_from_normalized,
           const GeoregisterOptions& options, Georegistration* result) {
  std::vector<double> residuals_sigmas;
  for (const auto& position : problem.positions) {
    const Eigen::Vector3d error =
        enu_from_normalized * position.center_in_world - position.center_in_enu;
    const bool has_height = position.height_accuracy_m < kUnknownHeightM;
    const double residual_m = has_height ? error.norm() : error.head<2>().norm();
    result->residuals_m.push_back(residual_m);
    residuals_sigmas.push_back(residual_m / position.accuracy_m);
    result->num_inliers += residuals_sigmas.back() <= 3.0 * kLossScaleSigmas;
  }
  std::vector<double> accuracies_m;
  for (const auto& position : problem.positions) {
    accuracies_m.push_back(position.accuracy_m);
  }
  result->stated_accuracy_m = Median(std::move(accuracies_m));
  result->num_positions = static_cast<int>(problem.positions.size());
  result->median_residual_m = Median(result->residuals_m);
  result->max_residual_m =
      *std::max_element(result->residuals_m.begin(), result->residuals_m.end());
  const double median_sigmas = Median(residuals_sigmas);
  if (result->num_inliers > 0 && median_sigmas <= options.max_median_residual_sigmas &&
      result->median_residual_m <= MaxMedianResidualM(options, result->stated_accuracy_m)) {
    return;
  }
  throw Error(ErrorCode::kBadInput,
              fmt::format("georegistration: the fit to {} positions is bad: {} inliers, median "
                          "residual {:.2f} m ({:.1f} times the stated accuracy; {}), largest "
                          "{:.2f} m; check that positions and images belong together, or state a "
                          "larger accuracy (--gps-accuracy, or the column accuracy_m)",
                          result->num_positions, result->num_inliers, result->median_residual_m,
                          median_sigmas, DescribeLimits(options, result->stated_accuracy_m),
                          result->max_residual_m));
}

}  // namespace

void GeoregisterOptions::Validate() const {
  RequireOption(upright_sigma_rad >= 0.0 && upright_sigma_rad < 2.0,
                "georegister.upright_sigma_rad must lie in [0, 2)");
  RequireOption(least_up_odds >= 1.0, "georegister.least_up_odds must be at least 1");
  RequireOption(max_median_residual_sigmas > 0.0,
                "georegister.max_median_residual_sigmas must be positive");
  RequireOption(max_median_residual_m > 0.0, "georegister.max_median_residual_m must be positive");
}

Georegistration Georegister(const Reconstruction& reconstruction,
                            const std::vector<CameraPosition>& positions,
                            const GeoregisterOptions& options,
                            const ImageOrientations& orientations) {
  options.Validate();
  reconstruction.Validate();
  const std::vector<MatchedPosition> matched = MatchByName(reconstruction, positions);
  if (static_cast<int>(matched.size()) < kMinPositions) {
    throw Error(
        ErrorCode::kBadInput,
        fmt::format("georegistration: {} of {} known positions belong to one of the {} "
                    "images; at least {} are needed",
                    matched.size(), positions.size(), reconstruction.images.size(), kMinPositions));
  }
  std::vector<Eigen::Vector3d> centers_in_ecef;
  for (const MatchedPosition& position : matched) {
    centers_in_ecef.push_back(position.center_in_ecef);
  }
  const Rigid3d ecef_from_enu = EcefFromEnu(GeodeticFromEcef(MedianPoint(centers_in_ecef)));
  const Sim3d normalized_from_world = NormalizedFromWorld(matched);
  SimilarityProblem problem;
  problem.positions = PositionsInEnu(matched, normalized_from_world, ecef_from_enu);
  RequireSpread(problem);
  Georegistration result;
  AddLevelCameras(reconstruction, orientations, normalized_from_world.scale, options, &problem,
                  &result.up);

  const std::optional<Sim3d> start = InitialSimilarity(problem);
  if (!start) {
    throw Error(
        ErrorCode::kBadInput,
        fmt::format("georegistration: {} known positions lie on a line and the upright prior "
                    "is off or undetermined, so the roll about the line is unknown",
                    matched.size()));
  }
  const Sim3d enu_from_normalized = RefineSimilarity(problem, *start);
  Judge(problem, enu_from_normalized, options, &result);
  RequireSpreadOfFit(problem, enu_from_normalized);
  result.accuracy = AccuracyOf(problem, matched, enu_from_normalized);
  if (options.up == UpSource::kPositions) {
    RequireKnownUp(result.accuracy);
  }
  result.ecef_from_world = ecef_from_enu * enu_from_normalized * normalized_from_world;
  FindFaults(matched, &result);
  return result;
}

std::vector<std::string> NotesOnOutliers(const Georegistration& georegistration) {
  std::vector<std::string> notes;
  const int num_outliers = georegistration.num_positions - georegistration.num_inliers;
  if (num_outliers > 0) {
    notes.push_back(fmt::format(
        "{}; that of {} is {:.0f} m from where the photos say",
        num_outliers == 1 ? "1 position disagrees and does not count"
                          : fmt::format("{} positions disagree and do not count", num_outliers),
        Excerpt(georegistration.worst_image), georegistration.max_residual_m));
  }
  if (georegistration.num_sign_errors > 0) {
    notes.push_back(
        fmt::format("{} of these would agree with the other sign of latitude or longitude",
                    georegistration.num_sign_errors));
  }
  return notes;
}

}  // namespace cairn
