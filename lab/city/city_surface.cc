#include "lab/city/city_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/angles.h"
#include "lab/city/hashed_random.h"
#include "lab/city/surface_streams.h"

namespace cairn {
namespace {

constexpr double kHourInYears = 1.0 / (24 * 365.25);

constexpr double kSignSpacingM = 22.0;
constexpr double kSignWidthM = 0.7, kSignHeightM = 3.0;
constexpr int kNumSignStyles = 25;
constexpr double kParkingSlotM = 5.5;
constexpr double kCarLengthM = 4.4, kCarHeightM = 1.4;
constexpr int kNumCarStyles = 40;
constexpr int kNumTreeStyles = 5;
constexpr double kGroundCellM = 6.0;

// Returns a rank in [0, count) by Zipf's law: rank r has a probability approximately proportional
// to 1 / (r + 1).
int ZipfRank(int count, HashedRandom* random) {
  return std::min(static_cast<int>(std::pow(count + 1.0, random->Uniform())) - 1, count - 1);
}

// A wall from `left` to `right`, both as seen from outside.
CitySurface Upright(const Eigen::Vector2d& left, const Eigen::Vector2d& right, double low_m,
                    double height_m) {
  CitySurface surface;
  surface.origin << left, low_m;
  surface.along = (right - left).normalized();
  surface.length_m = (right - left).norm();
  surface.height_m = height_m;
  return surface;
}

class SurfaceCollector {
 public:
  SurfaceCollector(const City& city, double time_years)
      : city_(city), shape_(city.shape()), time_years_(time_years) {}

  void AddBuilding(const CityBuilding& building) {
    // The front faces the street, which is to the right of the line from the first corner to the
    // second.
    AddWall(building, 0, 1);
    if (building.right_is_bare) {
      AddWall(building, 1, 2);
    }
    if (building.left_is_bare) {
      AddWall(building, 3, 0);
    }
  }

  void AddStreet(const CityStreet& street) {
    AddGround(street);
    AddSigns(street);
    AddTrees(street);
    AddVehicles(street);
  }

  std::vector<CitySurface> Take() { return std::move(surfaces_); }

 private:
  void AddWall(const CityBuilding& building, int from, int to) {
    const double height_m = building.top_m - building.ground_m;
    CitySurface wall =
        Upright(building.corners[from], building.corners[to], building.ground_m, height_m);
    wall.id = HashOf(building.id, from);
    wall.kind = SurfaceKind::kFacade;
    wall.num_cells_along = static_cast<int>(wall.length_m / shape_.bay_m);
    wall.num_cells_up = static_cast<int>(height_m / shape_.floor_m);
    wall.repeated_share = city_.options().RepeatedShare();
    wall.style = building.style;
    surfaces_.push_back(wall);
  }

  void AddGround(const CityStreet& street) {
    CitySurface ground;
    const Eigen::Vector2d corner = street.At(0.0, -0.5 * street.width_m);
    ground.id = HashOf(street.id, kGroundStream);
    ground.kind = SurfaceKind::kGround;
    ground.origin << corner, city_.GroundM(corner);
    ground.along = street.Direction();
    ground.length_m = street.LengthM();
    ground.height_m = street.width_m;
    ground.num_cells_along = std::max(1, static_cast<int>(ground.length_m / kGroundCellM));
    ground.repeated_share = 0.4;
    ground.density_factor = 0.25;
    ground.style = HashOf(kGroundStream, static_cast<int>(street.width_m));
    surfaces_.push_back(ground);
  }

  // Calls add(place, side, random) every `spacing_m` on both sides of the street. `side` is 1 on
  // the left.
  template <typename Add>
  void AlongKerbs(const CityStreet& street, SurfaceStream stream, double spacing_m,
                  const Add& add) {
    const double length_m = street.LengthM();
    const double margin_m = 0.5 * street.width_m;  // Keeps the crossing free.
    const int count = static_cast<int>((length_m - 2.0 * margin_m) / spacing_m);
    for (int k = 0; k < count; ++k) {
      for (const int side : {-1, 1}) {
        HashedRandom random(HashOf(street.id, stream, k, side + 1));
        const double along_m = margin_m + (k + random.Uniform(0.3, 0.7)) * spacing_m;
        const double left_m = side * (0.5 * street.width_m - street.sidewalk_m);
        add(street.At(along_m, left_m), side, &random);
      }
    }
  }

  void AddSigns(const CityStreet& street) {
    const Eigen::Vector2d direction = street.Direction();
    const Eigen::Vector2d left(-direction.y(), direction.x());
    AlongKerbs(street, kSignStream, kSignSpacingM,
               [&](const Eigen::Vector2d& place, int, HashedRandom* random) {
                 const uint64_t style = HashOf(kSignStream, ZipfRank(kNumSignStyles, random));
                 const double low_m = city_.GroundM(place) + 0.3;
                 for (const int face : {-1, 1}) {  // Faces both ends of the street.
                   const Eigen::Vector2d half = 0.5 * kSignWidthM * face * left;
                   CitySurface sign = Upright(place - half, place + half, low_m, kSignHeightM);
                   sign.id = random->Next();
                   sign.kind = SurfaceKind::kSign;
                   sign.repeated_share = 0.6;
                   sign.style = style;
                   surfaces_.push_back(sign);
                 }
               });
  }

  void AddTrees(const CityStreet& street) {
    if (shape_.tree_spacing_m <= 0.0) {
      return;
    }
    AlongKerbs(street, kTreeStream, shape_.tree_spacing_m,
               [&](const Eigen::Vector2d& place, int, HashedRandom* random) {
                 CitySurface tree;
                 tree.id = random->Next();
                 tree.kind = SurfaceKind::kTree;
                 tree.origin << place, city_.GroundM(place) + random->Uniform(1.8, 2.6);
                 tree.length_m = 2.0 * kPi * random->Uniform(1.2, 2.2);
                 tree.height_m = random->Uniform(3.0, 6.0);
                 tree.repeated_share = 0.2;
                 tree.style = HashOf(kTreeStream, ZipfRank(kNumTreeStyles, random));
                 surfaces_.push_back(tree);
               });
  }

  void AddVehicles(const CityStreet& street) {
    AlongKerbs(street, kParkingStream, kParkingSlotM,
               [&](const Eigen::Vector2d& place, int side, HashedRandom* random) {
                 const double lifetime = kHourInYears * city_.options().lifetime_factor;
                 HashedRandom now(
                     HashOf(random->Next(), EpochAt(time_years_, lifetime, random->Uniform())));
                 if (now.Chance(shape_.parked_share)) {
                   AddVehicle(street, place, side, &now);
                 }
               });
  }

  void AddVehicle(const CityStreet& street, const Eigen::Vector2d& place, int side,
                  HashedRandom* now) {
    const Eigen::Vector2d direction = street.Direction();
    const Eigen::Vector2d to_middle = -side * Eigen::Vector2d(-direction.y(), direction.x());
    const uint64_t style = HashOf(kParkingStream, ZipfRank(kNumCarStyles, now));
    const double low_m = city_.GroundM(place) + 0.2;
    for (const int face : {-1, 1}) {  // Faces the sidewalk and the road.
      const Eigen::Vector2d middle = place + (face + 1.0) * 0.9 * to_middle;
      const Eigen::Vector2d half = 0.5 * kCarLengthM * face * side * direction;
      CitySurface car = Upright(middle - half, middle + half, low_m, kCarHeightM);
      car.id = now->Next();
      car.kind = SurfaceKind::kVehicle;
      car.repeated_share = 0.7;
      car.style = style;
      surfaces_.push_back(car);
    }
  }

  const City& city_;
  const CityShape& shape_;
  double time_years_;
  std::vector<CitySurface> surfaces_;
};

}  // namespace

Eigen::Vector2d CitySurface::MiddleInPlan() const {
  switch (kind) {
    case SurfaceKind::kTree:
      return origin.head<2>();
    case SurfaceKind::kGround:
      return origin.head<2>() + 0.5 * length_m * along +
             0.5 * height_m * Eigen::Vector2d(-along.y(), along.x());
    default:
      return origin.head<2>() + 0.5 * length_m * along;
  }
}

double CitySurface::RadiusInPlanM() const {
  constexpr double kMarginM = 0.5;  // Covers things that stand out.
  switch (kind) {
    case SurfaceKind::kTree:
      return length_m / (2.0 * kPi) + kMarginM;
    case SurfaceKind::kGround:
      return 0.5 * std::hypot(length_m, height_m);
    default:
      return 0.5 * length_m + kMarginM;
  }
}

std::vector<CitySurface> SurfacesIn(const City& city, const CityBox& box, double time_years) {
  SurfaceCollector collector(city, time_years);
  for (const CityBuilding& building : city.BuildingsIn(box)) {
    collector.AddBuilding(building);
  }
  for (const CityStreet& street : city.StreetsIn(box)) {
    collector.AddStreet(street);
  }
  return collector.Take();
}

}  // namespace cairn
