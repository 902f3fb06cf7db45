// What keypoints sit on: walls, streets, trees, signs and parked cars, and the landmarks on them.
#ifndef CAIRN_LAB_CITY_GEOMETRY_CITY_SURFACE_H_
#define CAIRN_LAB_CITY_GEOMETRY_CITY_SURFACE_H_

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "lab/city/geometry/city.h"

namespace cairn {

enum class SurfaceKind { kFacade, kGround, kTree, kSign, kVehicle };

// A rectangle that stands upright, lies on the ground (kGround) or is rolled up to an upright
// cylinder about its origin (kTree).
struct CitySurface {
  uint64_t id = 0;
  SurfaceKind kind = SurfaceKind::kFacade;
  // Upright: lower left corner, seen from outside. In site.
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  // Horizontal unit vector to the right, seen from outside; on the ground, along the street.
  Eigen::Vector2d along = Eigen::Vector2d::UnitX();
  double length_m = 0.0;  // Along; of a tree its circumference.
  double height_m = 0.0;  // Upwards; on the ground to the left.
  // Landmarks with a likeness stand at the same places in each cell of this grid, and in the cells
  // of every other surface of the same style.
  int num_cells_along = 1, num_cells_up = 1;
  double repeated_share = 0.0;
  double density_factor = 1.0;  // Relative to facades.
  uint64_t style = 0;

  Eigen::Vector2d MiddleInPlan() const;
  // No landmark is further from the middle.
  double RadiusInPlanM() const;
};

// Something that a feature detector finds, as it is at one time.
struct CityLandmark {
  uint64_t id = 0;        // Another one as soon as something else takes its place.
  uint64_t ornament = 0;  // The same for all that look like it, else the id.
  Eigen::Vector3d x_in_site = Eigen::Vector3d::Zero();
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  // Of the surface, outwards; unit.
  // Unit vector in the surface: where the keypoint's dominant gradient points.
  Eigen::Vector3f pointer = Eigen::Vector3f::Zero();
  float size_m = 0.0f;    // Physical; the standard deviation of the detector's Gaussian.
  float salience = 0.0f;  // Standard normal over all landmarks: how readily it is detected.
};

// All surfaces that touch the box; the time matters for what is parked. Always in the same order.
std::vector<CitySurface> SurfacesIn(const City& city, const CityBox& box, double time_years);

// The landmarks of a surface, the largest first. Sizes s are distributed like s^-3, as in scenes
// that look alike at any distance. A pure function of its arguments.
std::vector<CityLandmark> LandmarksOn(const City& city, const CitySurface& surface,
                                      double time_years);

}  // namespace cairn

#endif  // CAIRN_LAB_CITY_GEOMETRY_CITY_SURFACE_H_
