#include "lab/city/geometry/city_surface.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/angles.h"
#include "lab/city/geometry/hashed_random.h"

namespace cairn {
namespace {

// Landmarks per square meter of facade, in units of 1 / CityOptions::min_landmark_size_m^2. With
// this value, a photo that is full of facade has this many keypoints of at least one pixel per
// square pixel (measured: docs/simulated_city.md).
constexpr double kFacadeDensity = 0.004;
constexpr double kMaxSizeM = 2.0;
constexpr double kHourInYears = 1.0 / (24 * 365.25);

constexpr double kSignSpacingM = 22.0;
constexpr double kSignWidthM = 0.7, kSignHeightM = 3.0;
constexpr int kNumSignStyles = 25;
constexpr double kParkingSlotM = 5.5;
constexpr double kCarLengthM = 4.4, kCarHeightM = 1.4;
constexpr int kNumCarStyles = 40;
constexpr int kNumTreeStyles = 5;
constexpr double kGroundCellM = 6.0;

// Streams of random numbers that must stay separate.
enum Stream : uint64_t {
  kGroundStream = 0x201,
  kTreeStream,
  kSignStream,
  kParkingStream,
  kElement,
  kUnique,
  kSlotTiming,
};

// Lifetimes of a kind of thing, in years, each with the share of the landmarks that have it.
struct Lifetimes {
  struct Class {
    double share;
    double years;
  };
  std::array<Class, 3> classes;
};

Lifetimes LifetimesOf(SurfaceKind kind, bool is_ground_floor) {
  switch (kind) {
    case SurfaceKind::kFacade:
      return is_ground_floor ? Lifetimes{{{{0.4, 40.0}, {0.2, 8.0}, {0.4, 0.7}}}}
                             : Lifetimes{{{{0.7, 40.0}, {0.22, 8.0}, {0.08, 0.7}}}};
    case SurfaceKind::kGround:
      return {{{{0.5, 12.0}, {0.2, 3.0}, {0.3, 0.05}}}};
    case SurfaceKind::kTree:
      return {{{{0.1, 5.0}, {0.2, 1.0}, {0.7, 0.25}}}};
    case SurfaceKind::kSign:
      return {{{{0.7, 15.0}, {0.2, 4.0}, {0.1, 0.3}}}};
    case SurfaceKind::kVehicle:
      break;  // SurfacesIn replaces whole cars.
  }
  return {{{{1.0, 40.0}, {0.0, 1.0}, {0.0, 1.0}}}};
}

// Returns the number of the thing that occupies a place at a time. Things in one place succeed each
// other.
int64_t EpochAt(double time_years, double lifetime_years, double phase) {
  return static_cast<int64_t>(std::floor(time_years / lifetime_years + phase));
}

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
  void AlongKerbs(const CityStreet& street, Stream stream, double spacing_m, const Add& add) {
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

// A landmark's place on its surface and its properties, before the landmark is placed in the city.
struct Spot {
  double along_m = 0.0, up_m = 0.0, out_m = 0.0;
  double angle_rad = 0.0;
  double size_m = 0.0;
  double salience = 0.0;
};

class LandmarkMaker {
 public:
  LandmarkMaker(const City& city, const CitySurface& surface, double time_years)
      : city_(city), surface_(surface), time_years_(time_years) {
    const double min_size_m = city.options().min_landmark_size_m;
    min_share_ = min_size_m * min_size_m / (kMaxSizeM * kMaxSizeM);
    expected_ = kFacadeDensity * surface.density_factor * surface.length_m * surface.height_m /
                (min_size_m * min_size_m);
  }

  std::vector<CityLandmark> Make() {
    const int num_cells = surface_.num_cells_along * surface_.num_cells_up;
    const double num_repeated = num_cells > 0 ? surface_.repeated_share * expected_ : 0.0;
    if (num_cells > 0) {
      const int num_elements = Round(num_repeated / num_cells, surface_.style);
      for (int element = 0; element < num_elements; ++element) {
        AddElement(element);
      }
    }
    const int num_unique = Round(expected_ - num_repeated, surface_.id);
    for (int k = 0; k < num_unique; ++k) {
      AddUnique(k);
    }
    std::sort(landmarks_.begin(), landmarks_.end(),
              [](const CityLandmark& a, const CityLandmark& b) {
                return a.size_m != b.size_m ? a.size_m > b.size_m : a.id < b.id;
              });
    return std::move(landmarks_);
  }

 private:
  // Rounds to a whole number such that the mean is right.
  static int Round(double value, uint64_t hash) {
    return static_cast<int>(value + HashedRandom(hash).Uniform());
  }

  Spot DrawSpot(double length_m, double height_m, HashedRandom* random) const {
    Spot spot;
    spot.along_m = length_m * random->Uniform();
    spot.up_m = height_m * random->Uniform();
    spot.angle_rad = random->Uniform(-kPi, kPi);
    spot.size_m = city_.options().min_landmark_size_m /
                  std::sqrt(std::max(min_share_, random->Uniform(min_share_, 1.0)));
    spot.salience = random->Normal();
    // Sills, balconies and cornices stand out from the wall. Leaves are anywhere in the crown.
    const bool stands_out = random->Chance(0.25);
    spot.out_m = stands_out ? random->Uniform(0.0, 0.4) : random->Uniform(-0.03, 0.03);
    return spot;
  }

  // Adds one element of the style to every cell.
  void AddElement(int element) {
    HashedRandom random(HashOf(surface_.style, kElement, element));
    const double cell_length_m = surface_.length_m / surface_.num_cells_along;
    const double cell_height_m = surface_.height_m / surface_.num_cells_up;
    const Spot in_cell = DrawSpot(cell_length_m, cell_height_m, &random);
    const uint64_t ornament = random.Next();
    for (int up = 0; up < surface_.num_cells_up; ++up) {
      for (int along = 0; along < surface_.num_cells_along; ++along) {
        Spot spot = in_cell;
        spot.along_m += along * cell_length_m;
        spot.up_m += up * cell_height_m;
        const uint64_t slot = HashOf(surface_.id, kElement, element, up, along);
        const uint64_t id = IdNow(slot, spot);
        HashedRandom own(id);  // Salience differs by curtains, dirt and shadows.
        spot.salience = std::sqrt(0.5) * (spot.salience + own.Normal());
        Place(spot, id, ornament);
      }
    }
  }

  // Adds a landmark that has no repetition.
  void AddUnique(int k) {
    // The slot determines the place, so that a successor is near its predecessor.
    const uint64_t slot = HashOf(surface_.id, kUnique, k);
    HashedRandom place(slot);
    const Spot where = DrawSpot(surface_.length_m, surface_.height_m, &place);
    const uint64_t id = IdNow(slot, where);
    HashedRandom own(id);
    Spot spot = DrawSpot(surface_.length_m, surface_.height_m, &own);
    spot.along_m = where.along_m;
    spot.up_m = where.up_m;
    Place(spot, id, id);
  }

  // Returns the id of the thing that is in a slot now.
  uint64_t IdNow(uint64_t slot, const Spot& spot) const {
    const bool is_ground_floor = spot.up_m < city_.shape().floor_m;
    const Lifetimes lifetimes = LifetimesOf(surface_.kind, is_ground_floor);
    HashedRandom random(HashOf(slot, kSlotTiming));
    double draw = random.Uniform();
    double years = lifetimes.classes.back().years;
    for (const Lifetimes::Class& of_kind : lifetimes.classes) {
      if (draw < of_kind.share) {
        years = of_kind.years;
        break;
      }
      draw -= of_kind.share;
    }
    years *= city_.options().lifetime_factor * random.Uniform(0.5, 1.5);
    return HashOf(slot, EpochAt(time_years_, years, random.Uniform()));
  }

  void Place(const Spot& spot, uint64_t id, uint64_t ornament) {
    CityLandmark landmark;
    landmark.id = id;
    landmark.ornament = ornament;
    landmark.size_m = static_cast<float>(spot.size_m);
    landmark.salience = static_cast<float>(spot.salience);
    Eigen::Vector3d right, up, normal;  // Axes of the surface at this place.
    if (surface_.kind == SurfaceKind::kTree) {
      const double radius_m = surface_.length_m / (2.0 * kPi);
      const double angle_rad = spot.along_m / radius_m;
      normal = {std::cos(angle_rad), std::sin(angle_rad), 0.0};
      right = {-normal.y(), normal.x(), 0.0};
      up = Eigen::Vector3d::UnitZ();
      landmark.x_in_site = surface_.origin + (radius_m - spot.out_m) * normal + spot.up_m * up;
    } else {
      right << surface_.along, 0.0;
      const bool lies = surface_.kind == SurfaceKind::kGround;
      up = lies ? Eigen::Vector3d(-right.y(), right.x(), 0.0) : Eigen::Vector3d::UnitZ();
      normal = right.cross(up);
      landmark.x_in_site = surface_.origin + spot.along_m * right + spot.up_m * up;
      if (lies) {
        landmark.x_in_site.z() = city_.GroundM(landmark.x_in_site.head<2>());
      } else if (surface_.kind == SurfaceKind::kFacade) {
        landmark.x_in_site += spot.out_m * normal;
      }
    }
    landmark.normal = normal.cast<float>();
    landmark.pointer =
        (std::sin(spot.angle_rad) * right - std::cos(spot.angle_rad) * up).cast<float>();
    landmarks_.push_back(landmark);
  }

  const City& city_;
  const CitySurface& surface_;
  double time_years_;
  double min_share_ = 0.0;
  double expected_ = 0.0;
  std::vector<CityLandmark> landmarks_;
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

std::vector<CityLandmark> LandmarksOn(const City& city, const CitySurface& surface,
                                      double time_years) {
  return LandmarkMaker(city, surface, time_years).Make();
}

}  // namespace cairn
