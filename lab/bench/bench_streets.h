// The streets of the bench world: where landmarks hang, where vehicles drive. All positions are in
// `site`: east-north-up at the crossing where the tiles meet, z from the ground.
#ifndef CAIRN_LAB_BENCH_BENCH_STREETS_H_
#define CAIRN_LAB_BENCH_BENCH_STREETS_H_

#include <Eigen/Core>
#include <cstdint>
#include <random>
#include <vector>

#include "core/geodesy.h"
#include "core/rigid3.h"

namespace cairn {

// A lane: one direction of one street.
struct BenchLane {
  bool is_east_west = false;  // Else it runs north-south.
  double street_m = 0.0;      // Coordinate of the street's middle line across it.
  int travel_sign = 1;        // Vehicles drive towards rising (1) or falling (-1) coordinates.

  bool operator==(const BenchLane&) const = default;

  // A point over the street's middle line.
  Eigen::Vector3d At(double along_m, double height_m) const;
  // Direction of travel, counter-clockwise from east.
  double YawRad() const;
  // How far ahead of a vehicle at `from_along_m` a coordinate along the street is.
  double AheadM(double from_along_m, double along_m) const {
    return travel_sign * (along_m - from_along_m);
  }
};

// A landmark on a facade, seen by vehicles in one lane.
struct BenchLandmark {
  uint64_t number = 0;  // Names its descriptors, see DescriptorModel.
  Eigen::Vector3d x_in_site = Eigen::Vector3d::Zero();
  BenchLane lane;
  double along_m = 0.0;          // Coordinate along the street.
  double orientation_rad = 0.0;  // Gravity-rectified.
  double size_m = 0.0;           // Physical, of the keypoint.
  int num_descriptors = 0;
};

// Distances ahead at which vehicles and queries see landmarks.
inline constexpr double kBenchMinViewM = 5.0;
inline constexpr double kBenchMaxViewM = 30.0;
inline constexpr double kBenchCameraHeightM = 1.6;

// The lane in which all queries stand.
BenchLane QueryLane(int travel_sign);

// The crossing on Earth: the common corner of 4 tiles, the middle of the common side of 2, or the
// middle of 1. On a central meridian, where the tile grid is aligned to east and north.
Geodetic BenchSiteOrigin(int num_tiles);
// The middles of the tiles in site.
std::vector<Eigen::Vector2d> BenchTileCenters(int num_tiles);

// A landmark on a random lane within the tile about `tile_center`.
BenchLandmark RandomLandmark(const Eigen::Vector2d& tile_center, std::mt19937_64* generator);

// A camera without roll at a place; yaw counter-clockwise from east, pitch upwards.
Rigid3d CamFromSite(const Eigen::Vector3d& center_in_site, double yaw_rad, double pitch_rad);

}  // namespace cairn

#endif  // CAIRN_LAB_BENCH_BENCH_STREETS_H_
