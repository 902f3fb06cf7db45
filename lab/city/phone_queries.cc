#include "lab/city/phone_queries.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/angles.h"
#include "core/check.h"
#include "core/error.h"
#include "core/radius68.h"
#include "core/require.h"
#include "lab/city/camera_angles.h"
#include "lab/city/city_region.h"
#include "lab/city/clutter.h"
#include "lab/city/hashed_random.h"
#include "lab/city/smooth_field.h"

namespace cairn {
namespace {

constexpr double kOutlierFactor = 3.0;
constexpr double kBiasWaveM = 60.0;
constexpr double kMaxViewTurnRad = 1.3;  // Between the view and straight across the street.
constexpr double kMeanPitchRad = 0.1, kPitchSigmaRad = 0.1;
constexpr double kRollSigmaRad = 0.06;
constexpr double kHeightSigmaM = 0.08;
constexpr double kMinAccuracyM = 3.0, kMaxAccuracyM = 150.0;
constexpr int kMaxTries = 10'000;

// Streams of random numbers that must stay separate.
enum QueryStream : uint64_t {
  kPlaceStream = 0x501,
  kQueryImageStream,
  kQueryClutterStream,
  kModeStream,
  kMappedStream,
  kQueryGpsStream,
  kQueryBiasStream,
  kGravityStream,
  kIntrinsicsStream,
};

double MeanBuildingHeightM(const CityShape& shape) {
  // The mean of heights that grow with the square of a uniform number.
  return shape.min_height_m + (shape.max_height_m - shape.min_height_m) / 3.0;
}

double YawRad(const CityStreet& street) {
  const Eigen::Vector2d direction = street.Direction();
  return std::atan2(direction.y(), direction.x());
}

PhonePlace DrawPlace(const City& city, const PhoneQueryOptions& options, int query_idx) {
  const double half_m = 0.5 * city.options().SideM();
  for (int attempt = 0; attempt < kMaxTries; ++attempt) {
    HashedRandom random(HashOf(options.seed, kPlaceStream, query_idx, attempt));
    const Eigen::Vector2d near(random.Uniform(-half_m, half_m), random.Uniform(-half_m, half_m));
    const std::vector<CityStreet> streets = city.StreetsIn(BoxAroundPoint(near, 0.5));
    if (streets.empty()) {
      continue;
    }
    const CityStreet& street =
        streets[static_cast<size_t>(random.Index(static_cast<int>(streets.size())))];
    const int side = random.Chance(0.5) ? 1 : -1;
    const double along_m = (near - street.begin).dot(street.Direction());
    const double left_m =
        side * (0.5 * street.width_m - random.Uniform(0.3, 0.9) * std::max(1.0, street.sidewalk_m));
    const Eigen::Vector2d at = street.At(along_m, left_m);
    if (along_m < 0.0 || along_m > street.LengthM() || !city.Contains(at)) {
      continue;
    }
    CameraAngles angles;
    angles.yaw_rad =
        YawRad(street) - side * 0.5 * kPi + random.Uniform(-kMaxViewTurnRad, kMaxViewTurnRad);
    angles.pitch_rad = kMeanPitchRad + kPitchSigmaRad * random.Normal();
    angles.roll_rad = kRollSigmaRad * random.Normal();
    const double z_m = city.GroundM(at) + options.height_m + kHeightSigmaM * random.Normal();
    return PlaceBeside(city, street, CamFromEnu({at.x(), at.y(), z_m}, angles));
  }
  throw Error(
      ErrorCode::kInvalidArgument,
      fmt::format("city.area_km2 = {}: the area has no sidewalk for queries; make it larger",
                  city.options().area_km2));
}

std::vector<PhonePlace> DrawPlaces(const City& city, const PhoneQueryOptions& options) {
  options.Validate();
  std::vector<PhonePlace> places;
  places.reserve(static_cast<size_t>(options.num_queries));
  for (int i = 0; i < options.num_queries; ++i) {
    places.push_back(DrawPlace(city, options, i));
  }
  return places;
}

}  // namespace

PhonePlace PlaceBeside(const City& city, const CityStreet& street, const Rigid3d& cam_from_site) {
  return {cam_from_site, YawRad(street), MeanBuildingHeightM(city.shape()) / street.width_m};
}

void PhoneNoise::Validate() const {
  RequireWithin("queries.noise.gps_median_m", gps_median_m, 0.0, 10'000.0);
  RequireWithin("queries.noise.gps_log_sigma", gps_log_sigma, 0.0, 3.0);
  RequireWithin("queries.noise.gps_outlier_share", gps_outlier_share, 0.0, 1.0);
  RequireWithin("queries.noise.canyon_bias_m", canyon_bias_m, 0.0, 1000.0);
  RequireWithin("queries.noise.height_sigma_m", height_sigma_m, 0.0, 1000.0);
  RequireWithin("queries.noise.accuracy_log_sigma", accuracy_log_sigma, 0.0, 3.0);
  RequireWithin("queries.noise.gravity_sigma_rad", gravity_sigma_rad, 0.0, 1.0);
  RequireWithin("queries.noise.focal_log_sigma", focal_log_sigma, 0.0, 0.5);
  RequireWithin("queries.noise.principal_point_sigma_px", principal_point_sigma_px, 0.0, 500.0);
}

void PhoneQueryOptions::Validate() const {
  RequireWithin("queries.num_queries", num_queries, 1, 1'000'000);
  RequireWithin("queries.num_keypoints", num_keypoints, 10, 20'000);
  RequireWithin("queries.mapped_fraction", mapped_fraction, 0.0, 1.0);
  RequireWithin("queries.mapped_log_sigma", mapped_log_sigma, 0.0, 3.0);
  RequireWithin("queries.unmapped_share", unmapped_share, 0.0, 1.0);
  RequireWithin("queries.time_years", time_years, 0.0, 200.0);
  RequireWithin("queries.num_appearance_modes", num_appearance_modes, 1, 1000);
  RequireWithin("queries.image_width_px", image_width_px, 64, 8192);
  RequireWithin("queries.image_height_px", image_height_px, 64, 8192);
  RequireWithin("queries.focal_px", focal_px, 20.0, 20'000.0);
  RequireWithin("queries.height_m", height_m, 0.2, 4.0);
  detector.Validate();
  noise.Validate();
}

PhoneQueries::PhoneQueries(const City& city, const DescriptorModel& model,
                           const PhoneQueryOptions& options)
    : PhoneQueries(city, model, options, DrawPlaces(city, options)) {}

PhoneQueries::PhoneQueries(const City& city, const DescriptorModel& model,
                           const PhoneQueryOptions& options, std::vector<PhonePlace> places)
    : city_(city),
      model_(model),
      options_((options.Validate(), options)),
      camera_(CameraModel::kPinhole, options.image_width_px, options.image_height_px,
              {options.focal_px, options.focal_px, 0.5 * options.image_width_px,
               0.5 * options.image_height_px}),
      places_(std::move(places)) {}

EvalQuery PhoneQueries::Make(int query_idx, const std::unordered_set<uint64_t>& mapped) const {
  const PhonePlace& place = Place(query_idx);
  EvalQuery query;
  query.name = fmt::format("phone_{:06}", query_idx);
  query.cam_from_ecef = place.cam_from_site * city_.ecef_from_site().Inverse();
  query.query.id = query.name;
  FillFeatures(query_idx, mapped, &query.query.features);

  std::vector<EvalQuery> one = {std::move(query)};
  AddNoisyPriors({.gravity_sigma_rad = options_.noise.gravity_sigma_rad,
                  .with_prior = false,
                  .seed = HashOf(options_.seed, kGravityStream)},
                 &one);
  query = std::move(one.front());

  HashedRandom random(HashOf(options_.seed, kIntrinsicsStream, query_idx));
  const double focal_px =
      options_.focal_px * std::exp(options_.noise.focal_log_sigma * random.Normal());
  const double cx_px =
      0.5 * options_.image_width_px + options_.noise.principal_point_sigma_px * random.Normal();
  const double cy_px =
      0.5 * options_.image_height_px + options_.noise.principal_point_sigma_px * random.Normal();
  query.query.camera = Camera(CameraModel::kPinhole, options_.image_width_px,
                              options_.image_height_px, {focal_px, focal_px, cx_px, cy_px});
  FillPrior(query_idx, &query.query);
  return query;
}

int PhoneQueries::NumMapped(uint64_t image_id) const {
  const double fraction =
      options_.mapped_fraction *
      std::exp(options_.mapped_log_sigma * HashedRandom(HashOf(image_id, kMappedStream)).Normal());
  return static_cast<int>(std::lround(std::min(fraction, 1.0) * options_.num_keypoints));
}

void PhoneQueries::FillFeatures(int query_idx, const std::unordered_set<uint64_t>& mapped,
                                FeatureSet* features) const {
  const Rigid3d& cam_from_site = Place(query_idx).cam_from_site;
  const CityRegion region(
      city_,
      BoxAroundPoint(cam_from_site.Inverse().translation.head<2>(), options_.detector.max_range_m),
      options_.time_years);
  const uint64_t image_id = HashOf(options_.seed, kQueryImageStream, query_idx);
  const std::vector<Detection> detections =
      DetectLandmarks(region, camera_, cam_from_site, options_.detector, image_id, image_id);
  const auto mode = static_cast<uint32_t>(
      HashedRandom(HashOf(image_id, kModeStream)).Index(options_.num_appearance_modes));

  features->descriptors.resize(options_.num_keypoints, DescriptorModel::kDim);
  const auto add = [&](bool is_mapped, int max_count) {
    for (const Detection& detection : detections) {
      if (max_count <= 0) {
        break;
      }
      if (mapped.contains(detection.look.landmark) == is_mapped) {
        DescriptorLook look = detection.look;
        look.appearance_mode = mode;
        features->descriptors.row(features->size()) = model_.Describe(look);
        features->keypoints.push_back(detection.keypoint);
        --max_count;
      }
    }
  };
  add(true, NumMapped(image_id));
  add(false, static_cast<int>(std::lround(options_.unmapped_share *
                                          (options_.num_keypoints - features->size()))));
  AppendClutter(camera_, options_.detector, model_, HashOf(image_id, kQueryClutterStream),
                options_.num_keypoints - features->size(), features);
}

void PhoneQueries::FillPrior(int query_idx, LocalizeQuery* query) const {
  const PhonePlace& place = Place(query_idx);
  const PhoneNoise& noise = options_.noise;
  HashedRandom random(HashOf(options_.seed, kQueryGpsStream, query_idx));
  const double sigma_m = noise.gps_median_m * std::exp(noise.gps_log_sigma * random.Normal());
  const double factor = random.Chance(noise.gps_outlier_share) ? kOutlierFactor : 1.0;
  const double east_m = factor * sigma_m * random.Normal();
  const double north_m = factor * sigma_m * random.Normal();
  const double up_m = noise.height_sigma_m * random.Normal();

  const Eigen::Vector3d center = place.cam_from_site.Inverse().translation;
  const double bias_sigma_m = noise.canyon_bias_m * std::min(place.canyon, 2.0);
  const SmoothField bias(HashOf(options_.seed, kQueryBiasStream), 1.0, kBiasWaveM);
  const Eigen::Vector2d across(-std::sin(place.street_yaw_rad), std::cos(place.street_yaw_rad));
  const Eigen::Vector2d shift =
      bias_sigma_m * bias.ShiftM(center.head<2>()).x() * across + Eigen::Vector2d(east_m, north_m);

  PositionPrior prior;
  prior.position = GeodeticFromEcef(city_.ecef_from_site() *
                                    (center + Eigen::Vector3d(shift.x(), shift.y(), up_m)));
  const double expected_m =
      kRadius68PerSigma2d * std::sqrt(sigma_m * sigma_m + 0.5 * bias_sigma_m * bias_sigma_m);
  prior.accuracy_m = std::clamp(expected_m * std::exp(noise.accuracy_log_sigma * random.Normal()),
                                kMinAccuracyM, kMaxAccuracyM);
  prior.height_sigma_m = std::max(kMinAccuracyM, noise.height_sigma_m);
  query->prior = prior;
}

}  // namespace cairn
