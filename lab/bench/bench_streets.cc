#include "lab/bench/bench_streets.h"

#include <cmath>

#include "core/angles.h"
#include "core/tile_id.h"

namespace cairn {
namespace {

constexpr double kHalfTileM = 0.5 * TileId::kSideM;
constexpr double kStreetSpacingM = 50.0;
// Keeps the streets off the tiles' borders, so that each camera is in one tile.
constexpr double kFirstStreetM = 5.0;
constexpr double kFacadeOffsetM = 8.0;  // Distance from the middle of the street.
constexpr double kFacadeHeightM = 15.0;
constexpr double kGroundHeightM = 400.0;
constexpr int kMaxDescriptorsPerLandmark = 4;  // Uniform from 1: 2.5 on average.

double Uniform(double low, double high, std::mt19937_64* generator) {
  return std::uniform_real_distribution<double>(low, high)(*generator);
}

double RandomSign(std::mt19937_64* generator) {
  return std::bernoulli_distribution()(*generator) ? 1.0 : -1.0;
}

// Returns the center lines of the streets that cross a tile, along one axis.
std::vector<double> StreetsThrough(double tile_center_m) {
  const double low = tile_center_m - kHalfTileM - kFirstStreetM;
  const double high = tile_center_m + kHalfTileM - kFirstStreetM;
  std::vector<double> streets;
  for (int i = static_cast<int>(std::ceil(low / kStreetSpacingM)); i * kStreetSpacingM < high;
       ++i) {
    streets.push_back(kFirstStreetM + i * kStreetSpacingM);
  }
  return streets;
}

}  // namespace

Eigen::Vector3d BenchLane::At(double along_m, double height_m) const {
  return is_east_west ? Eigen::Vector3d(along_m, street_m, height_m)
                      : Eigen::Vector3d(street_m, along_m, height_m);
}

double BenchLane::YawRad() const {
  return (is_east_west ? 0.0 : 0.5 * kPi) + (travel_sign > 0 ? 0.0 : kPi);
}

BenchLane QueryLane(int travel_sign) {
  return {.is_east_west = true, .street_m = kFirstStreetM, .travel_sign = travel_sign};
}

Geodetic BenchSiteOrigin(int num_tiles) {
  const TileId tile = TileId::Containing(Geodetic::FromDegrees(47.4, 9.0, 0.0));
  const Eigen::Vector3d shift(num_tiles >= 2 ? kHalfTileM : 0.0, num_tiles == 4 ? kHalfTileM : 0.0,
                              kGroundHeightM);
  return GeodeticFromEcef(EcefFromEnu(tile.Anchor()) * shift);
}

std::vector<Eigen::Vector2d> BenchTileCenters(int num_tiles) {
  constexpr double h = kHalfTileM;
  switch (num_tiles) {
    case 1:
      return {{0.0, 0.0}};
    case 2:
      return {{-h, 0.0}, {h, 0.0}};
    default:
      return {{-h, -h}, {h, -h}, {-h, h}, {h, h}};
  }
}

BenchLandmark RandomLandmark(const Eigen::Vector2d& tile_center, std::mt19937_64* generator) {
  BenchLandmark landmark;
  landmark.lane.is_east_west = std::bernoulli_distribution()(*generator);
  const int along_axis = landmark.lane.is_east_west ? 0 : 1;
  const std::vector<double> streets = StreetsThrough(tile_center[1 - along_axis]);
  landmark.lane.street_m =
      streets[std::uniform_int_distribution<size_t>(0, streets.size() - 1)(*generator)];
  landmark.lane.travel_sign = static_cast<int>(RandomSign(generator));
  landmark.along_m = tile_center[along_axis] + Uniform(-kHalfTileM, kHalfTileM, generator);

  BenchLane facade = landmark.lane;
  facade.street_m += RandomSign(generator) * (kFacadeOffsetM + Uniform(-0.4, 0.4, generator));
  landmark.x_in_site = facade.At(landmark.along_m, Uniform(0.0, kFacadeHeightM, generator));
  landmark.orientation_rad = Uniform(-kPi, kPi, generator);
  landmark.size_m = std::exp(Uniform(std::log(0.02), std::log(0.5), generator));
  landmark.num_descriptors =
      std::uniform_int_distribution<int>(1, kMaxDescriptorsPerLandmark)(*generator);
  return landmark;
}

Rigid3d CamFromSite(const Eigen::Vector3d& center_in_site, double yaw_rad, double pitch_rad) {
  const Eigen::Vector3d forward(std::cos(yaw_rad) * std::cos(pitch_rad),
                                std::sin(yaw_rad) * std::cos(pitch_rad), std::sin(pitch_rad));
  const Eigen::Vector3d right(std::sin(yaw_rad), -std::cos(yaw_rad), 0.0);
  Eigen::Matrix3d site_from_cam;
  site_from_cam << right, forward.cross(right), forward;
  return Rigid3d(site_from_cam, center_in_site).Inverse();
}

}  // namespace cairn
