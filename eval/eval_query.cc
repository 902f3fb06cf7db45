#include "eval/eval_query.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>
#include <utility>

#include "core/angles.h"
#include "core/frames.h"
#include "core/radius68.h"
#include "core/require.h"

namespace cairn {
namespace {

// Reported accuracies are positive even without noise.
constexpr double kMinAccuracyM = 0.1;

// Turns `direction` by independent Gaussian angles about two axes perpendicular to it.
Eigen::Vector3d Tilted(const Eigen::Vector3d& direction, double first_rad, double second_rad) {
  const Eigen::Vector3d first_axis = direction.unitOrthogonal();
  const Eigen::Vector3d second_axis = direction.cross(first_axis);
  return (ExpSo3(first_rad * first_axis + second_rad * second_axis) * direction).normalized();
}

}  // namespace

std::mt19937_64 GeneratorOfQuery(const EvalQuery& query, uint64_t seed) {
  std::vector<uint32_t> words = {static_cast<uint32_t>(seed), static_cast<uint32_t>(seed >> 32)};
  for (const char letter : query.name) {
    words.push_back(static_cast<unsigned char>(letter));
  }
  std::seed_seq sequence(words.begin(), words.end());
  return std::mt19937_64(sequence);
}

void PriorNoiseOptions::Validate() const {
  constexpr double kMaxSigmaM = 10e3;
  RequireWithin("noise.position_sigma_m", position_sigma_m, 0.0, kMaxSigmaM);
  RequireWithin("noise.height_sigma_m", height_sigma_m, 0.0, kMaxSigmaM);
  RequireWithin("noise.gravity_sigma_rad", gravity_sigma_rad, 0.0, 1.0);
}

void AddNoisyPriors(const PriorNoiseOptions& options, std::vector<EvalQuery>* queries) {
  options.Validate();
  for (EvalQuery& query : *queries) {
    std::mt19937_64 generator = GeneratorOfQuery(query, options.seed);
    std::normal_distribution<double> normal;
    // Draws all numbers whether they are used or not, so that switching off one prior does not
    // change the other.
    const double east_m = options.position_sigma_m * normal(generator);
    const double north_m = options.position_sigma_m * normal(generator);
    const double up_m = options.height_sigma_m * normal(generator);
    const double tilt_a_rad = options.gravity_sigma_rad * normal(generator);
    const double tilt_b_rad = options.gravity_sigma_rad * normal(generator);

    const Geodetic truth = GeodeticFromEcef(query.cam_from_ecef.Inverse().translation);
    const Rigid3d ecef_from_enu = EcefFromEnu(truth);
    query.query.prior.reset();
    if (options.with_prior) {
      Geodetic position = GeodeticFromEcef(ecef_from_enu * Eigen::Vector3d(east_m, north_m, 0.0));
      position.h_m = truth.h_m + up_m;
      query.query.prior = {position,
                           std::max(kMinAccuracyM, kRadius68PerSigma2d * options.position_sigma_m),
                           std::max(kMinAccuracyM, options.height_sigma_m)};
    }
    query.query.down_in_cam.reset();
    if (options.with_gravity) {
      const Eigen::Vector3d down_in_cam =
          (query.cam_from_ecef * ecef_from_enu).rotation * DownInEnu();
      query.query.down_in_cam = Tilted(down_in_cam, tilt_a_rad, tilt_b_rad);
    }
  }
}

void OffsetPriors(double distance_m, uint64_t seed, std::vector<EvalQuery>* queries) {
  RequireOption(std::isfinite(distance_m), "the offset of priors must be finite");
  for (EvalQuery& query : *queries) {
    if (!query.query.prior) {
      continue;
    }
    // Uses other random numbers than AddNoisyPriors for the same query.
    std::mt19937_64 generator = GeneratorOfQuery(query, ~seed);
    std::uniform_real_distribution<double> direction_rad(0.0, 2.0 * kPi);
    const double azimuth_rad = direction_rad(generator);
    Geodetic& position = query.query.prior->position;
    const double h_m = position.h_m;
    position = GeodeticFromEcef(
        EcefFromEnu(position) *
        (distance_m * Eigen::Vector3d(std::sin(azimuth_rad), std::cos(azimuth_rad), 0.0)));
    position.h_m = h_m;
  }
}

std::vector<EvalQuery> QueriesFromReconstruction(const Reconstruction& reconstruction,
                                                 const Sim3d& ecef_from_world,
                                                 const std::string& image_dir) {
  std::vector<EvalQuery> queries;
  queries.reserve(reconstruction.images.size());
  for (const ReconImage& image : reconstruction.images) {
    EvalQuery query;
    query.name = image.name;
    if (!image_dir.empty()) {
      query.image_path = (std::filesystem::path(image_dir) / image.name).string();
    }
    query.query.id = image.name;
    query.query.camera = reconstruction.cameras[image.camera_idx];
    query.query.features = image.features.Unpacked();
    query.cam_from_ecef = CamFromTarget(image.cam_from_world, ecef_from_world);
    queries.push_back(std::move(query));
  }
  return queries;
}

}  // namespace cairn
