// The streets of the bench world: the places of landmarks and the lanes of vehicles. All positions
// are in `site`, which is east-north-up at the crossing where the tiles meet; z is the height above
// the ground.
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
  bool is_east_west = false;  // Otherwise the street runs north-south.
  double street_m = 0.0;      // Coordinate of the street's center line, across the street.
  // Vehicles drive in the direction of rising (1) or falling (-1) coordinates.
  int travel_sign = 1;

  bool operator==(const BenchLane&) const = default;

  // Returns a point above the street's center line.
  Eigen::Vector3d At(double along_m, double height_m) const;
  // Returns the direction of travel, counterclockwise from east.
  double YawRad() const;
  // Returns the distance from a vehicle at `from_along_m` forward to a coordinate along the street.
  double AheadM(double from_along_m, double along_m) const {
    return travel_sign * (along_m - from_along_m);
  }
};

// A landmark on a facade. Vehicles in one lane see it.
struct BenchLandmark {
  uint64_t number = 0;  // Determines its descriptors; see DescriptorModel.
  Eigen::Vector3d x_in_site = Eigen::Vector3d::Zero();
  BenchLane lane;
  double along_m = 0.0;          // Coordinate along the street.
  double orientation_rad = 0.0;  // Gravity-rectified.
  double size_m = 0.0;           // Physical size of the keypoint.
  int num_descriptors = 0;
};

// Distances ahead at which vehicles and queries see landmarks.
inline constexpr double kBenchMinViewM = 5.0;
inline constexpr double kBenchMaxViewM = 30.0;
inline constexpr double kBenchCameraHeightM = 1.6;

// The lane of all queries.
BenchLane QueryLane(int travel_sign);

// Returns the crossing's position on Earth: the common corner of 4 tiles, the middle of the common
// side of 2, or the middle of 1. The crossing is on a central meridian, where the tile grid is
// aligned to east and north.
Geodetic BenchSiteOrigin(int num_tiles);
// Returns the centers of the tiles, in site.
std::vector<Eigen::Vector2d> BenchTileCenters(int num_tiles);

// Draws a landmark on a random lane within the tile around `tile_center`.
BenchLandmark RandomLandmark(const Eigen::Vector2d& tile_center, std::mt19937_64* generator);

// Returns the pose of a camera without roll. Yaw is counterclockwise from east, pitch upward.
Rigid3d CamFromSite(const Eigen::Vector3d& center_in_site, double yaw_rad, double pitch_rad);

}  // namespace cairn

#endif  // CAIRN_LAB_BENCH_BENCH_STREETS_H_
