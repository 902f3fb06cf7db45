// The plan of a simulated city: ground, streets, buildings.
#ifndef CAIRN_LAB_CITY_GEOMETRY_CITY_H_
#define CAIRN_LAB_CITY_GEOMETRY_CITY_H_

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <vector>

#include "core/rigid3.h"
#include "lab/city/geometry/city_options.h"

namespace cairn {

// Metres in `site`, east and north.
using CityBox = Eigen::AlignedBox2d;

CityBox BoxAroundPoint(const Eigen::Vector2d& middle, double radius_m);

// A straight street between two crossings.
struct CityStreet {
  uint64_t id = 0;
  Eigen::Vector2d begin = Eigen::Vector2d::Zero(), end = Eigen::Vector2d::Zero();  // Middle line.
  double width_m = 0.0;     // Between the properties on both sides.
  double sidewalk_m = 0.0;  // Width of each of its two sidewalks.

  double LengthM() const { return (end - begin).norm(); }
  Eigen::Vector2d Direction() const { return (end - begin).normalized(); }
  // A point `along_m` from the beginning and `left_m` to the left of the middle line.
  Eigen::Vector2d At(double along_m, double left_m) const {
    const Eigen::Vector2d direction = Direction();
    return begin + along_m * direction + left_m * Eigen::Vector2d(-direction.y(), direction.x());
  }
};

// A house: a quadrilateral with upright walls and a flat top.
struct CityBuilding {
  uint64_t id = 0;
  // Counter-clockwise: the front's two ends (the street is to the right of the way from the first
  // to the second), the rear's two.
  std::array<Eigen::Vector2d, 4> corners;
  double ground_m = 0.0, top_m = 0.0;  // z in site.
  bool left_is_bare = false;           // The wall at corners[0] can be seen from the street,
  bool right_is_bare = false;          // and the one at corners[1].
  uint64_t style = 0;                  // Of the facade: one of the town's, or its own.
};

// What a character means in metres.
struct CityShape {
  double pitch_x_m, pitch_y_m;  // Between crossings.
  double jitter;                // Of a crossing, share of the pitch.
  double street_m, sidewalk_m;
  double min_height_m, max_height_m;  // Of buildings; low ones are more frequent.
  double min_lot_m, max_lot_m;        // Along the street.
  double depth_m;
  double setback_m;        // From the property line to the front.
  double gap_share;        // Of a lot's width that is not built on.
  double row_share;        // Of houses that have the style of their neighbour,
  double own_style_share;  // and of those that have a style of their own.
  double floor_m, bay_m;   // Of the grid of windows.
  double tree_spacing_m;   // Along both sides of the street; 0 is none.
  double parked_share;     // Of the kerb's length.
};

// The plan of the city: a pure function of its options, without limit; what is outside of the
// square Contains() knows is there to be seen from within. All positions are in `site`:
// east-north-up at the center. Immutable; safe to use from any thread.
class City {
 public:
  // Throws Error(kInvalidArgument) as CityOptions::Validate.
  explicit City(const CityOptions& options);

  const CityOptions& options() const { return options_; }
  const CityShape& shape() const { return shape_; }
  const Rigid3d& ecef_from_site() const { return ecef_from_site_; }

  // Is the point within the mapped square?
  bool Contains(const Eigen::Vector2d& at) const;
  // z of the ground, which falls away from the plane with the curvature of the Earth.
  double GroundM(const Eigen::Vector2d& at) const;

  // Everything that touches the box; streets and buildings always in the same order.
  std::vector<CityStreet> StreetsIn(const CityBox& box) const;
  std::vector<CityBuilding> BuildingsIn(const CityBox& box) const;

 private:
  Eigen::Vector2d Crossing(int i, int j) const;
  // From crossing (i, j) to (i + 1, j) if axis is 0, to (i, j + 1) if it is 1.
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
  // Of what houses and streets look like. Cities of another character share no looks, whatever
  // their seed: a photo of the one shows nothing of the other.
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

#endif  // CAIRN_LAB_CITY_GEOMETRY_CITY_H_
