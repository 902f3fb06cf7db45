#include "lab/city/city.h"

#include <algorithm>
#include <cmath>

#include "core/angles.h"
#include "lab/city/hashed_random.h"

namespace cairn {
namespace {

constexpr double kEarthRadiusM = 6.371e6;
constexpr double kMaxStreetTurnRad = 0.35;  // Angle of the streets to east and north.
constexpr int kMainStreetEvery = 4;  // Average number of lines from one main street to the next.
constexpr double kMainStreetFactor = 1.5;
constexpr double kMinReliefWaveM = 250.0, kMaxReliefWaveM = 900.0;

// Streams of random numbers that must stay separate.
enum LayoutStream : uint64_t {
  kLayout = 0x101,
  kCrossing,
  kStreetId,
  kStreetLine,
  kRow,
  kBuilding,
  kStyle,
  kRelief,
};

constexpr std::array<CityShape, 4> kShapes = {{
    {.pitch_x_m = 70,
     .pitch_y_m = 60,
     .jitter = 0.18,
     .street_m = 9,
     .sidewalk_m = 1.5,
     .min_height_m = 10,
     .max_height_m = 18,
     .min_lot_m = 8,
     .max_lot_m = 14,
     .depth_m = 11,
     .setback_m = 0,
     .gap_share = 0,
     .row_share = 0.2,
     .own_style_share = 0.5,
     .floor_m = 3.2,
     .bay_m = 2.4,
     .tree_spacing_m = 0,
     .parked_share = 0.2},
    {.pitch_x_m = 113,
     .pitch_y_m = 113,
     .jitter = 0,
     .street_m = 20,
     .sidewalk_m = 5,
     .min_height_m = 16,
     .max_height_m = 27,
     .min_lot_m = 14,
     .max_lot_m = 24,
     .depth_m = 20,
     .setback_m = 0,
     .gap_share = 0,
     .row_share = 0.25,
     .own_style_share = 0.35,
     .floor_m = 3.5,
     .bay_m = 3,
     .tree_spacing_m = 10,
     .parked_share = 0.5},
    {.pitch_x_m = 110,
     .pitch_y_m = 70,
     .jitter = 0.08,
     .street_m = 13,
     .sidewalk_m = 2,
     .min_height_m = 5,
     .max_height_m = 9,
     .min_lot_m = 16,
     .max_lot_m = 24,
     .depth_m = 10,
     .setback_m = 5,
     .gap_share = 0.35,
     .row_share = 0.4,
     .own_style_share = 0.3,
     .floor_m = 2.8,
     .bay_m = 3,
     .tree_spacing_m = 14,
     .parked_share = 0.3},
    {.pitch_x_m = 120,
     .pitch_y_m = 90,
     .jitter = 0.02,
     .street_m = 26,
     .sidewalk_m = 4,
     .min_height_m = 18,
     .max_height_m = 120,
     .min_lot_m = 28,
     .max_lot_m = 50,
     .depth_m = 28,
     .setback_m = 2,
     .gap_share = 0.1,
     .row_share = 0.15,
     .own_style_share = 0.25,
     .floor_m = 3.6,
     .bay_m = 1.8,
     .tree_spacing_m = 18,
     .parked_share = 0.3},
}};

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

using Quad = std::array<Eigen::Vector2d, 4>;

// Returns the counterclockwise quadrilateral with side k (from corner k to the next) moved inward
// by offsets_m[k].
Quad Inset(const Quad& quad, const std::array<double, 4>& offsets_m) {
  std::array<Eigen::Vector2d, 4> points, directions;
  for (int k = 0; k < 4; ++k) {
    directions[k] = (quad[(k + 1) % 4] - quad[k]).normalized();
    points[k] = quad[k] + offsets_m[k] * Eigen::Vector2d(-directions[k].y(), directions[k].x());
  }
  Quad inset;
  for (int k = 0; k < 4; ++k) {  // Intersects side k - 1 with side k.
    const int before = (k + 3) % 4;
    const double along =
        Cross(points[k] - points[before], directions[k]) / Cross(directions[before], directions[k]);
    inset[k] = points[before] + along * directions[before];
  }
  return inset;
}

// Returns the approximate smallest distance between opposite sides.
double WidthM(const Quad& quad) {
  double width_m = 1e9;
  for (int k = 0; k < 2; ++k) {
    const Eigen::Vector2d middle = 0.5 * (quad[k] + quad[k + 1]);
    const Eigen::Vector2d opposite = 0.5 * (quad[k + 2] + quad[(k + 3) % 4]);
    width_m = std::min(width_m, (middle - opposite).norm());
  }
  return width_m;
}

bool Touches(const CityBox& box, const Quad& quad) {
  CityBox bounds;
  for (const Eigen::Vector2d& corner : quad) {
    bounds.extend(corner);
  }
  return box.intersects(bounds);
}

}  // namespace

CityBox BoxAroundPoint(const Eigen::Vector2d& middle, double radius_m) {
  const Eigen::Vector2d reach(radius_m, radius_m);
  return CityBox(middle - reach, middle + reach);
}

City::City(const CityOptions& options)
    : options_((options.Validate(), options)),
      looks_seed_(HashOf(options.seed, static_cast<int>(options.character))),
      shape_(kShapes[static_cast<size_t>(options.character)]),
      ecef_from_site_(EcefFromEnu(options.center)) {
  HashedRandom random(HashOf(options_.seed, kLayout));
  site_from_lattice_ = Eigen::Rotation2Dd(random.Uniform(-kMaxStreetTurnRad, kMaxStreetTurnRad));
  double sum = 0.0;
  for (int rank = 1; rank <= options_.num_styles; ++rank) {
    style_cdf_.push_back(sum += 1.0 / rank);
  }
  for (double& value : style_cdf_) {
    value /= sum;
  }
  HashedRandom relief(HashOf(options_.seed, kRelief));
  for (Wave& wave : relief_) {
    const double direction_rad = relief.Uniform(0.0, 2.0 * kPi);
    const double radians_per_m = 2.0 * kPi / relief.Uniform(kMinReliefWaveM, kMaxReliefWaveM);
    wave.radians_per_m =
        radians_per_m * Eigen::Vector2d(std::cos(direction_rad), std::sin(direction_rad));
    wave.phase_rad = relief.Uniform(0.0, 2.0 * kPi);
  }
}

bool City::Contains(const Eigen::Vector2d& at) const {
  return at.cwiseAbs().maxCoeff() <= 0.5 * options_.SideM();
}

double City::GroundM(const Eigen::Vector2d& at) const {
  double sum = 0.0;
  for (const Wave& wave : relief_) {
    sum += std::sin(wave.radians_per_m.dot(at) + wave.phase_rad);
  }
  return 0.5 * options_.relief_m * sum / static_cast<double>(relief_.size()) -
         0.5 * at.squaredNorm() / kEarthRadiusM;
}

Eigen::Vector2d City::Crossing(int i, int j) const {
  HashedRandom random(HashOf(options_.seed, kCrossing, i, j));
  const double x = i + shape_.jitter * random.Uniform(-1.0, 1.0);
  const double y = j + shape_.jitter * random.Uniform(-1.0, 1.0);
  // The city's center is in the middle of a street.
  return site_from_lattice_ * Eigen::Vector2d((x - 0.5) * shape_.pitch_x_m, y * shape_.pitch_y_m);
}

double City::StreetWidthM(int axis, int line) const {
  HashedRandom random(HashOf(options_.seed, kStreetLine, axis, line));
  return shape_.street_m * (random.Index(kMainStreetEvery) == 0 ? kMainStreetFactor : 1.0);
}

CityStreet City::StreetAt(int axis, int i, int j) const {
  CityStreet street;
  street.id = HashOf(looks_seed_, kStreetId, axis, i, j);
  street.begin = Crossing(i, j);
  street.end = axis == 0 ? Crossing(i + 1, j) : Crossing(i, j + 1);
  street.width_m = StreetWidthM(axis, axis == 0 ? j : i);
  street.sidewalk_m = shape_.sidewalk_m;
  return street;
}

template <typename Visit>
void City::ForBlocksIn(const CityBox& box, const Visit& visit) const {
  CityBox lattice;
  for (const auto corner :
       {CityBox::BottomLeft, CityBox::BottomRight, CityBox::TopLeft, CityBox::TopRight}) {
    const Eigen::Vector2d at = site_from_lattice_.inverse() * box.corner(corner);
    lattice.extend(Eigen::Vector2d(at.x() / shape_.pitch_x_m + 0.5, at.y() / shape_.pitch_y_m));
  }
  const auto first = [](double value) { return static_cast<int>(std::floor(value)) - 1; };
  const auto last = [](double value) { return static_cast<int>(std::ceil(value)); };
  for (int j = first(lattice.min().y()); j <= last(lattice.max().y()); ++j) {
    for (int i = first(lattice.min().x()); i <= last(lattice.max().x()); ++i) {
      visit(i, j);
    }
  }
}

std::vector<CityStreet> City::StreetsIn(const CityBox& box) const {
  std::vector<CityStreet> streets;
  ForBlocksIn(box, [&](int i, int j) {
    for (const int axis : {0, 1}) {
      const CityStreet street = StreetAt(axis, i, j);
      const double half_m = 0.5 * street.width_m;
      const double length_m = street.LengthM();
      if (Touches(box, {street.At(0, half_m), street.At(0, -half_m), street.At(length_m, -half_m),
                        street.At(length_m, half_m)})) {
        streets.push_back(street);
      }
    }
  });
  return streets;
}

std::vector<CityBuilding> City::BuildingsIn(const CityBox& box) const {
  std::vector<CityBuilding> buildings;
  ForBlocksIn(box, [&](int i, int j) { AppendBlock(i, j, &buildings); });
  std::erase_if(buildings,
                [&](const CityBuilding& building) { return !Touches(box, building.corners); });
  return buildings;
}

void City::AppendBlock(int i, int j, std::vector<CityBuilding>* buildings) const {
  const Quad crossings = {Crossing(i, j), Crossing(i + 1, j), Crossing(i + 1, j + 1),
                          Crossing(i, j + 1)};
  std::array<double, 4> offsets_m = {0.5 * StreetWidthM(0, j), 0.5 * StreetWidthM(1, i + 1),
                                     0.5 * StreetWidthM(0, j + 1), 0.5 * StreetWidthM(1, i)};
  for (double& offset_m : offsets_m) {
    offset_m += shape_.setback_m;
  }
  const Quad front = Inset(crossings, offsets_m);
  // The limit keeps courtyards open and the rear a quadrilateral.
  const double depth_m = std::min(shape_.depth_m, 0.3 * WidthM(front));
  for (double& offset_m : offsets_m) {
    offset_m += depth_m;
  }
  const Quad rear = Inset(crossings, offsets_m);
  for (int side = 0; side < 4; ++side) {
    AppendRow({HashOf(options_.seed, kRow, i, j, side), front[side], front[(side + 1) % 4],
               rear[side], rear[(side + 1) % 4]},
              buildings);
  }
}

uint64_t City::DrawStyle(double uniform) const {
  const auto rank = std::lower_bound(style_cdf_.begin(), style_cdf_.end(), uniform);
  return HashOf(looks_seed_, kStyle, rank - style_cdf_.begin());
}

void City::AppendRow(const Row& row, std::vector<CityBuilding>* buildings) const {
  const double length_m = (row.front_end - row.front_begin).norm();
  HashedRandom random(row.id);
  std::vector<double> lot_ends_m;
  for (double end_m = 0.0; end_m < length_m;) {
    lot_ends_m.push_back(end_m += random.Uniform(shape_.min_lot_m, shape_.max_lot_m));
  }
  double begin = 0.0;
  for (size_t lot = 0; lot < lot_ends_m.size(); ++lot) {
    const double end = lot_ends_m[lot] / lot_ends_m.back();
    const double half_gap = 0.5 * shape_.gap_share * (end - begin);
    CityBuilding building;
    building.id = HashOf(row.id, kBuilding, lot, looks_seed_);
    HashedRandom facts(HashOf(row.id, kBuilding, lot));
    const auto at = [](const Eigen::Vector2d& from, const Eigen::Vector2d& to, double share) {
      return Eigen::Vector2d(from + share * (to - from));
    };
    building.corners = {at(row.front_begin, row.front_end, begin + half_gap),
                        at(row.front_begin, row.front_end, end - half_gap),
                        at(row.rear_begin, row.rear_end, end - half_gap),
                        at(row.rear_begin, row.rear_end, begin + half_gap)};
    building.ground_m = GroundM(0.5 * (building.corners[0] + building.corners[1]));
    const double tallness = facts.Uniform();
    building.top_m = building.ground_m + shape_.min_height_m +
                     (shape_.max_height_m - shape_.min_height_m) * tallness * tallness;
    building.left_is_bare = building.right_is_bare = shape_.gap_share > 0.0;
    const uint64_t town_style = DrawStyle(facts.Uniform());
    building.style = facts.Chance(shape_.own_style_share) ? building.id : town_style;
    if (facts.Chance(shape_.row_share) && lot > 0) {
      building.style = buildings->back().style;
    }
    buildings->push_back(building);
    begin = end;
  }
}

}  // namespace cairn
