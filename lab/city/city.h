// The plan of a simulated city: ground, streets and buildings.
#ifndef CAIRN_LAB_CITY_CITY_H_
#define CAIRN_LAB_CITY_CITY_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

#include "core/rigid3.h"
#include "lab/city/city_options.h"

namespace cairn {

// A box in `site`, in meters east and north.
using CityBox = Eigen::AlignedBox2d;

CityBox BoxAroundPoint(const Eigen::Vector2d& middle, double radius_m);

// A straight street between two crossings.
struct CityStreet {
  uint64_t id = 0;
  Eigen::Vector2d begin = Eigen::Vector2d::Zero(), end = Eigen::Vector2d::Zero();  // Center line.
  double width_m = 0.0;     // Between the properties on both sides.
  double sidewalk_m = 0.0;  // Width of each of the two sidewalks.

  double LengthM() const { return (end - begin).norm(); }
  Eigen::Vector2d Direction() const { return (end - begin).normalized(); }
  // Returns the point that is `along_m` from the beginning and `left_m` to the left of the center
  // line.
  Eigen::Vector2d At(double along_m, double left_m) const {
    const Eigen::Vector2d direction = Direction();
    return begin + along_m * direction + left_m * Eigen::Vector2d(-direction.y(), direction.x());
  }
};

// A house: a quadrilateral with vertical walls and a flat top.
struct CityBuilding {
  uint64_t id = 0;
  // Counterclockwise: the two ends of the front, then the two ends of the rear. The street is to
  // the right of the line from the first corner to the second.
  std::array<Eigen::Vector2d, 4> corners;
  double ground_m = 0.0, top_m = 0.0;  // z in site.
  bool left_is_bare = false;           // The wall at corners[0] is visible from the street.
  bool right_is_bare = false;          // The wall at corners[1] is visible from the street.
  uint64_t style = 0;                  // Facade style: one of the town's, or its own.
};

// A city's character, expressed in meters.
struct CityShape {
  double pitch_x_m, pitch_y_m;  // Distance between crossings.
  double jitter;                // Displacement of crossings / pitch.
  double street_m, sidewalk_m;
  double min_height_m, max_height_m;  // Building heights; low ones are more frequent.
  double min_lot_m, max_lot_m;        // Width along the street.
  double depth_m;
  double setback_m;        // From the property line to the front.
  double gap_share;        // Share of a lot's width that is not built on.
  double row_share;        // Share of houses in their neighbor's style.
  double own_style_share;  // Share of houses with a style of their own.
  double floor_m, bay_m;   // Spacing of the window grid.
  double tree_spacing_m;   // On both sides of the street; 0: no trees.
  double parked_share;     // Share of the curb's length.
};

// The plan of the city, a pure function of its options. The plan has no borders: beyond the square
// of Contains() it exists so that it can be seen from inside. All positions are in `site`, which is
// east-north-up at the center. Immutable; safe to use from any thread.
class City {
 public:
  // Throws the Error(kInvalidArgument) of CityOptions::Validate.
  explicit City(const CityOptions& options);

  const CityOptions& options() const { return options_; }
  const CityShape& shape() const { return shape_; }
  const Rigid3d& ecef_from_site() const { return ecef_from_site_; }

  // Returns true if the point is within the mapped square.
  bool Contains(const Eigen::Vector2d& at) const;
  // Returns z of the ground. The ground falls away from the plane with the Earth's curvature.
  double GroundM(const Eigen::Vector2d& at) const;

  // Return everything that touches the box. Streets and buildings always come in the same order.
  std::vector<CityStreet> StreetsIn(const CityBox& box) const;
  std::vector<CityBuilding> BuildingsIn(const CityBox& box) const;

 private:
  Eigen::Vector2d Crossing(int i, int j) const;
  // The street from crossing (i, j) to (i + 1, j) if axis is 0, or to (i, j + 1) if axis is 1.
  CityStreet StreetAt(int axis, int i, int j) const;
  double StreetWidthM(int axis, int line) const;
  void AppendBlock(int i, int j, std::vector<CityBuilding>* buildings) const;
  // The houses between the lines front_begin..front_end and rear_begin..rear_end.
  struct Row {
    uint64_t id;
    Eigen::Vector2d front_begin, front_end, rear_begin, rear_end;
  };
  void AppendRow(const Row& row, std::vector<CityBuilding>* buildings) const;
  uint64_t DrawStyle(double uniform) const;
  // Calls visit(i, j) for every block that may touch the box.
  template <typename Visit>
  void ForBlocksIn(const CityBox& box, const Visit& visit) const;

  CityOptions options_;
  // Seed of the looks of houses and streets. Cities of different characters share no looks,
  // whatever their seeds: a photo of one city shows nothing of another.
  uint64_t looks_seed_;
  CityShape shape_;
  Rigid3d ecef_from_site_;
  Eigen::Rotation2Dd site_from_lattice_;
  std::vector<double> style_cdf_;
  struct Wave {
    Eigen::Vector2d radians_per_m;
    double phase_rad;
  };
  std::array<Wave, 5> relief_;
};

}  // namespace cairn

#endif  // CAIRN_LAB_CITY_CITY_H_
