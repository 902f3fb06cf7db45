// Builds a part of the city as it is at one time and keeps it in memory.
#ifndef CAIRN_LAB_CITY_CITY_REGION_H_
#define CAIRN_LAB_CITY_CITY_REGION_H_

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "lab/city/city.h"
#include "lab/city/city_surface.h"

namespace cairn {

struct RegionSurface {
  CitySurface surface;
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  double radius_m = 0.0;                // Horizontal.
  std::vector<CityLandmark> landmarks;  // Largest first.
};

// Surfaces with their landmarks, and the buildings that hide them. Immutable; safe to use from any
// thread.
class CityRegion {
 public:
  // Builds everything that touches the box. Takes about 0.3 microseconds per landmark.
  CityRegion(const City& city, const CityBox& box, double time_years);

  double time_years() const { return time_years_; }
  const std::vector<RegionSurface>& surfaces() const { return surfaces_; }
  int64_t num_landmarks() const { return num_landmarks_; }

  // Returns true if a building of the region stands between the two points. The last 0.2 m before
  // `to` do not count, so that a wall does not hide what is on it.
  bool IsHidden(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const;

 private:
  // An extruded convex quadrilateral. A point is inside if normal . x <= offset for all sides.
  struct Block {
    std::array<Eigen::Vector2d, 4> normals;
    std::array<double, 4> offsets;
    double top_m = 0.0;

    bool Hides(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const;
  };
  void AddBlock(const CityBuilding& building);
  int CellOf(int column, int row) const { return row * num_columns_ + column; }

  double time_years_;
  std::vector<RegionSurface> surfaces_;
  int64_t num_landmarks_ = 0;
  std::vector<Block> blocks_;
  // A uniform grid over the buildings' bounds. Each cell lists indices into blocks_.
  CityBox grid_bounds_;
  int num_columns_ = 0, num_rows_ = 0;
  std::vector<std::vector<uint32_t>> cells_;
};

}  // namespace cairn

#endif  // CAIRN_LAB_CITY_CITY_REGION_H_
