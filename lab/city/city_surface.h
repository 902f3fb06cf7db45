// The surfaces that carry keypoints (walls, streets, trees, signs, parked cars) and their
// landmarks.
#ifndef CAIRN_LAB_CITY_CITY_SURFACE_H_
#define CAIRN_LAB_CITY_CITY_SURFACE_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "lab/city/city.h"

namespace cairn {

enum class SurfaceKind { kFacade, kGround, kTree, kSign, kVehicle };

// A rectangle. It stands upright, lies on the ground (kGround), or is rolled up to an upright
// cylinder about its origin (kTree).
struct CitySurface {
  uint64_t id = 0;
  SurfaceKind kind = SurfaceKind::kFacade;
  // A point in site. For an upright surface: the lower left corner, seen from outside.
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  // Horizontal unit vector to the right, seen from outside. On the ground: along the street.
  Eigen::Vector2d along = Eigen::Vector2d::UnitX();
  double length_m = 0.0;  // In the direction of `along`; of a tree, the circumference.
  double height_m = 0.0;  // Upward; on the ground, to the left.
  // Repeated landmarks have the same place in each cell of this grid and in the cells of every
  // other surface of the same style.
  int num_cells_along = 1, num_cells_up = 1;
  double repeated_share = 0.0;
  double density_factor = 1.0;  // Relative to facades.
  uint64_t style = 0;

  Eigen::Vector2d MiddleInPlan() const;
  // Largest horizontal distance of a landmark from the middle.
  double RadiusInPlanM() const;
};

// A point that a feature detector finds, as it is at one time.
struct CityLandmark {
  uint64_t id = 0;        // Changes as soon as another thing takes its place.
  uint64_t ornament = 0;  // Shared by all that look alike; otherwise the id.
  Eigen::Vector3d x_in_site = Eigen::Vector3d::Zero();
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  // Outward unit normal of the surface.
  // Unit vector in the surface in the direction of the keypoint's dominant gradient.
  Eigen::Vector3f pointer = Eigen::Vector3f::Zero();
  float size_m = 0.0f;    // Physical: the standard deviation of the detector's Gaussian.
  float salience = 0.0f;  // Ease of detection; standard normal over all landmarks.
};

// Returns all surfaces that touch the box, always in the same order. The time determines which cars
// are parked.
std::vector<CitySurface> SurfacesIn(const City& city, const CityBox& box, double time_years);

// Returns the landmarks of a surface, largest first. Their sizes s are distributed like s^-3, as in
// scenes that look alike at any distance. A pure function of its arguments.
std::vector<CityLandmark> LandmarksOn(const City& city, const CitySurface& surface,
                                      double time_years);

}  // namespace cairn

#endif  // CAIRN_LAB_CITY_CITY_SURFACE_H_
