// The part of city_surface.h that makes landmarks.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/angles.h"
#include "lab/city/city_surface.h"
#include "lab/city/hashed_random.h"
#include "lab/city/surface_streams.h"

namespace cairn {
namespace {

// Landmarks per square meter of facade, in units of 1 / CityOptions::min_landmark_size_m^2. With
// this value, a photo that is full of facade has this many keypoints of at least one pixel per
// square pixel (measured: docs/simulated_city.md).
constexpr double kFacadeDensity = 0.004;
constexpr double kMaxSizeM = 2.0;

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

std::vector<CityLandmark> LandmarksOn(const City& city, const CitySurface& surface,
                                      double time_years) {
  return LandmarkMaker(city, surface, time_years).Make();
}

}  // namespace cairn
