#include "lab/city/city.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/tile_id.h"
#include "lab/city/city_options.h"
#include "lab/city/city_region.h"
#include "lab/city/city_surface.h"
#include "lab/city/hashed_random.h"

namespace cairn {
namespace {

constexpr CityCharacter kAllCharacters[] = {CityCharacter::kOldTown, CityCharacter::kGrid,
                                            CityCharacter::kSuburb, CityCharacter::kHighRise};

CityOptions Sparse(CityCharacter character) {
  CityOptions options = CityPreset(character);
  options.min_landmark_size_m = 0.1;
  return options;
}

double SignedAreaSqM(const std::array<Eigen::Vector2d, 4>& corners) {
  double twice = 0.0;
  for (int k = 0; k < 4; ++k) {
    const Eigen::Vector2d &a = corners[k], &b = corners[(k + 1) % 4];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return 0.5 * twice;
}

bool IsInside(const CityBuilding& building, const Eigen::Vector2d& at, double margin_m) {
  for (int k = 0; k < 4; ++k) {
    const Eigen::Vector2d side = building.corners[(k + 1) % 4] - building.corners[k];
    const Eigen::Vector2d inwards = Eigen::Vector2d(-side.y(), side.x()).normalized();
    if (inwards.dot(at - building.corners[k]) < margin_m) {
      return false;
    }
  }
  return true;
}

std::string MessageOf(const CityOptions& options) {
  try {
    options.Validate();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
    return error.what();
  }
  return "";
}

TEST(HashedRandom, IsUniformAndNormal) {
  double sum = 0.0, sum_normal = 0.0, sum_sq_normal = 0.0;
  constexpr int kCount = 20'000;
  for (int i = 0; i < kCount; ++i) {
    HashedRandom random(HashOf(7, i));
    sum += random.Uniform();
    const double normal = random.Normal();
    sum_normal += normal;
    sum_sq_normal += normal * normal;
  }
  EXPECT_NEAR(sum / kCount, 0.5, 0.01);
  EXPECT_NEAR(sum_normal / kCount, 0.0, 0.03);
  EXPECT_NEAR(sum_sq_normal / kCount, 1.0, 0.05);
}

TEST(HashedRandom, DependsOnTheOrderOfWords) { EXPECT_NE(HashOf(1, 2, 3), HashOf(1, 3, 2)); }

TEST(CityOptions, RefuseWhatCannotBe) {
  CityOptions options;
  options.area_km2 = 0.0;
  EXPECT_THAT(MessageOf(options), testing::HasSubstr("city.area_km2 = 0"));
  options.area_km2 = 1e6;
  EXPECT_THAT(MessageOf(options), testing::HasSubstr("the nearest possible value is 900"));
  options.area_km2 = std::nan("");
  EXPECT_THAT(MessageOf(options), testing::HasSubstr("city.area_km2 = nan"));
  options = {};
  options.min_landmark_size_m = -0.1;
  EXPECT_THAT(MessageOf(options), testing::HasSubstr("city.min_landmark_size_m"));
  options = {};
  options.center.lat_rad = 1.5;
  EXPECT_THAT(MessageOf(options), testing::HasSubstr("city.center"));
  options = {};
  options.relief_m = -1.0;
  EXPECT_THAT(MessageOf(options), testing::HasSubstr("city.relief_m"));
}

TEST(CityOptions, NamesAreReadBack) {
  for (const CityCharacter character : kAllCharacters) {
    EXPECT_EQ(CityCharacterFromName(CityCharacterName(character)), character);
  }
  EXPECT_THROW(CityCharacterFromName("village"), Error);
}

TEST(CityOptions, PresetsCoverAZoneBorderAndAHighLatitude) {
  const Rigid3d ecef_from_site = EcefFromEnu(CityPreset(CityCharacter::kSuburb).center);
  const auto zone_at = [&](double east_m) {
    return TileId::Containing(GeodeticFromEcef(ecef_from_site * Eigen::Vector3d(east_m, 0, 0)))
        .zone();
  };
  EXPECT_EQ(zone_at(-50.0), 32);
  EXPECT_EQ(zone_at(50.0), 33);
  EXPECT_GT(CityPreset(CityCharacter::kHighRise).center.lat_deg(), 60.0);
}

TEST(City, BuildingsAreConvexAndDoNotOverlap) {
  for (const CityCharacter character : kAllCharacters) {
    const City city(Sparse(character));
    const std::vector<CityBuilding> buildings =
        city.BuildingsIn(BoxAroundPoint(Eigen::Vector2d::Zero(), 150.0));
    ASSERT_GT(buildings.size(), 20u) << CityCharacterName(character);
    for (const CityBuilding& building : buildings) {
      EXPECT_GT(SignedAreaSqM(building.corners), 5.0);
      EXPECT_GT(building.top_m, building.ground_m + 4.0);
      Eigen::Vector2d middle = Eigen::Vector2d::Zero();
      for (const Eigen::Vector2d& corner : building.corners) {
        middle += 0.25 * corner;
      }
      int num_inside = 0;
      for (const CityBuilding& other : buildings) {
        num_inside += IsInside(other, middle, 0.0);
      }
      EXPECT_EQ(num_inside, 1);
    }
  }
}

TEST(City, StreetsAreFreeOfBuildings) {
  for (const CityCharacter character : kAllCharacters) {
    const City city(Sparse(character));
    const CityBox box = BoxAroundPoint(Eigen::Vector2d::Zero(), 150.0);
    const std::vector<CityBuilding> buildings = city.BuildingsIn(box);
    for (const CityStreet& street : city.StreetsIn(box)) {
      for (double along_m = 0.0; along_m < street.LengthM(); along_m += 3.0) {
        for (const double share : {-0.48, 0.0, 0.48}) {
          const Eigen::Vector2d at = street.At(along_m, share * street.width_m);
          EXPECT_TRUE(std::none_of(
              buildings.begin(), buildings.end(),
              [&](const CityBuilding& building) { return IsInside(building, at, 0.0); }));
        }
      }
    }
  }
}

TEST(City, APartIsWhatTheWholeHasThere) {
  const City city(Sparse(CityCharacter::kOldTown));
  const CityBox small = BoxAroundPoint({40.0, -30.0}, 35.0);
  std::set<uint64_t> of_whole;
  for (const CityBuilding& building :
       city.BuildingsIn(BoxAroundPoint(Eigen::Vector2d::Zero(), 200.0))) {
    of_whole.insert(building.id);
  }
  const std::vector<CityBuilding> of_part = city.BuildingsIn(small);
  ASSERT_FALSE(of_part.empty());
  for (const CityBuilding& building : of_part) {
    EXPECT_TRUE(of_whole.contains(building.id));
  }
}

TEST(City, GroundHasTheReliefAndFallsWithTheEarth) {
  CityOptions options = Sparse(CityCharacter::kOldTown);
  options.relief_m = 40.0;
  const City city(options);
  double low_m = 1e9, high_m = -1e9;
  for (int i = 0; i < 4000; ++i) {
    HashedRandom random(i);
    const double height_m =
        city.GroundM({random.Uniform(-1500.0, 1500.0), random.Uniform(-1500.0, 1500.0)});
    low_m = std::min(low_m, height_m);
    high_m = std::max(high_m, height_m);
  }
  EXPECT_GT(high_m - low_m, 20.0);
  EXPECT_LT(high_m - low_m, 41.0);

  options.relief_m = 0.0;
  const City flat(options);
  const Eigen::Vector2d far(7000.0, -7000.0);
  const Geodetic ground = GeodeticFromEcef(flat.ecef_from_site() *
                                           Eigen::Vector3d(far.x(), far.y(), flat.GroundM(far)));
  EXPECT_NEAR(ground.h_m, options.center.h_m, 0.1);
}

TEST(City, StylesArePopularAsZipfsLawHasIt) {
  CityOptions options = Sparse(CityCharacter::kGrid);
  const City city(options);
  std::map<uint64_t, int> num_houses;
  int num_all = 0;
  for (const CityBuilding& building :
       city.BuildingsIn(BoxAroundPoint(Eigen::Vector2d::Zero(), 1500.0))) {
    ++num_houses[building.style];
    ++num_all;
  }
  std::vector<int> counts;
  for (const auto& [style, count] : num_houses) {
    counts.push_back(count);
  }
  std::sort(counts.rbegin(), counts.rend());
  ASSERT_GT(counts.size(), 100u);  // Among them many houses of their own kind.
  // Of 40 styles the first has a share of 1 / H(40) = 0.234, the second half of it.
  const double of_town = num_all * (1.0 - city.shape().own_style_share);
  EXPECT_NEAR(counts[0] / of_town, 0.234, 0.05);
  EXPECT_NEAR(counts[1] / of_town, 0.117, 0.03);
  EXPECT_NEAR(counts[9] / of_town, 0.023, 0.01);
}

TEST(CitySurface, LandmarksSitOnTheirSurfaceAndRepeat) {
  CityOptions options = Sparse(CityCharacter::kGrid);
  options.repeated_share = 0.5;
  const City city(options);
  int64_t num_landmarks = 0, num_repeated = 0;
  for (const CitySurface& surface :
       SurfacesIn(city, BoxAroundPoint(Eigen::Vector2d::Zero(), 100.0), 0.0)) {
    if (surface.kind != SurfaceKind::kFacade) {
      continue;
    }
    const Eigen::Vector3d right(surface.along.x(), surface.along.y(), 0.0);
    for (const CityLandmark& landmark : LandmarksOn(city, surface, 0.0)) {
      const Eigen::Vector3d offset = landmark.x_in_site - surface.origin;
      EXPECT_GE(offset.dot(right), -1e-9);
      EXPECT_LE(offset.dot(right), surface.length_m + 1e-9);
      EXPECT_LE(offset.z(), surface.height_m + 1e-9);
      EXPECT_LE(std::abs(offset.dot(landmark.normal.cast<double>())), 0.41);
      EXPECT_NEAR(landmark.normal.dot(landmark.pointer), 0.0f, 1e-5f);
      ++num_landmarks;
      num_repeated += landmark.ornament != landmark.id;
    }
  }
  ASSERT_GT(num_landmarks, 2000);
  EXPECT_NEAR(static_cast<double>(num_repeated) / num_landmarks, 0.5, 0.05);
}

TEST(CitySurface, AnOrnamentRepeatsAlongTheFacadeAndAcrossTown) {
  const City city(Sparse(CityCharacter::kGrid));
  std::map<uint64_t, std::vector<Eigen::Vector3d>> places;
  for (const CitySurface& surface :
       SurfacesIn(city, BoxAroundPoint(Eigen::Vector2d::Zero(), 250.0), 0.0)) {
    if (surface.kind == SurfaceKind::kFacade) {
      for (const CityLandmark& landmark : LandmarksOn(city, surface, 0.0)) {
        if (landmark.ornament != landmark.id) {
          places[landmark.ornament].push_back(landmark.x_in_site);
        }
      }
    }
  }
  int num_near = 0, num_far = 0;
  for (const auto& [ornament, at] : places) {
    ASSERT_FALSE(at.empty());
    const auto is_within = [&](double m) {
      return std::any_of(at.begin() + 1, at.end(),
                         [&](const Eigen::Vector3d& other) { return (other - at[0]).norm() < m; });
    };
    num_near += is_within(4.0);
    num_far += std::any_of(at.begin(), at.end(),
                           [&](const auto& other) { return (other - at[0]).norm() > 100.0; });
  }
  EXPECT_GT(num_near, 0.8 * static_cast<double>(places.size()));
  EXPECT_GT(num_far, 0.12 * static_cast<double>(places.size()));  // Many houses are unlike others.
}

TEST(CitySurface, SizesFollowAnInverseCube) {
  CityOptions options = Sparse(CityCharacter::kOldTown);
  options.min_landmark_size_m = 0.03;
  const CityRegion region(City(options), BoxAroundPoint(Eigen::Vector2d::Zero(), 60.0), 0.0);
  int num_all = 0, num_twice = 0, num_four_times = 0;
  for (const RegionSurface& surface : region.surfaces()) {
    EXPECT_TRUE(std::is_sorted(
        surface.landmarks.begin(), surface.landmarks.end(),
        [](const CityLandmark& a, const CityLandmark& b) { return a.size_m > b.size_m; }));
    for (const CityLandmark& landmark : surface.landmarks) {
      EXPECT_GE(landmark.size_m, 0.0299f);
      ++num_all;
      num_twice += landmark.size_m > 0.06f;
      num_four_times += landmark.size_m > 0.12f;
    }
  }
  ASSERT_GT(num_all, 5000);
  EXPECT_NEAR(num_twice / static_cast<double>(num_all), 0.25, 0.02);
  EXPECT_NEAR(num_four_times / static_cast<double>(num_all), 0.0625, 0.012);
}

std::set<uint64_t> IdsAt(const City& city, double time_years, SurfaceKind kind) {
  std::set<uint64_t> ids;
  for (const CitySurface& surface :
       SurfacesIn(city, BoxAroundPoint(Eigen::Vector2d::Zero(), 80.0), time_years)) {
    if (surface.kind == kind) {
      for (const CityLandmark& landmark : LandmarksOn(city, surface, time_years)) {
        ids.insert(landmark.id);
      }
    }
  }
  return ids;
}

double ShareLeft(const City& city, double years, SurfaceKind kind) {
  const std::set<uint64_t> before = IdsAt(city, 10.0, kind),
                           after = IdsAt(city, 10.0 + years, kind);
  int num_left = 0;
  for (const uint64_t id : before) {
    num_left += after.contains(id);
  }
  return static_cast<double>(num_left) / static_cast<double>(before.size());
}

TEST(CitySurface, ThingsGoAndOthersComeInTheirOwnTime) {
  const City city(Sparse(CityCharacter::kGrid));
  EXPECT_EQ(ShareLeft(city, 0.0, SurfaceKind::kFacade), 1.0);
  const double one_year = ShareLeft(city, 1.0, SurfaceKind::kFacade);
  EXPECT_GT(one_year, 0.75);
  EXPECT_LT(one_year, 0.95);
  EXPECT_LT(ShareLeft(city, 10.0, SurfaceKind::kFacade), 0.75);
  EXPECT_LT(ShareLeft(city, 1.0, SurfaceKind::kTree), 0.35);
  EXPECT_LT(ShareLeft(city, 0.01, SurfaceKind::kVehicle), 0.05);
  const size_t before = IdsAt(city, 10.0, SurfaceKind::kFacade).size();
  EXPECT_EQ(IdsAt(city, 20.0, SurfaceKind::kFacade).size(), before);
}

TEST(CityRegion, SameSeedMakesTheSameCityAndAnotherAnother) {
  const CityOptions options = Sparse(CityCharacter::kHighRise);
  CityOptions other = options;
  other.seed = 2;
  const auto first_ids = [](const CityOptions& of) {
    const CityRegion region(City(of), BoxAroundPoint(Eigen::Vector2d::Zero(), 50.0), 3.0);
    std::vector<uint64_t> ids;
    for (const RegionSurface& surface : region.surfaces()) {
      for (const CityLandmark& landmark : surface.landmarks) {
        ids.push_back(landmark.id);
      }
    }
    return ids;
  };
  EXPECT_EQ(first_ids(options), first_ids(options));
  EXPECT_NE(first_ids(options), first_ids(other));
}

TEST(CityRegion, BuildingsHideWhatIsBehindThemButNotTheirFronts) {
  const City city(Sparse(CityCharacter::kOldTown));
  const CityBox box = BoxAroundPoint(Eigen::Vector2d::Zero(), 120.0);
  const CityRegion region(city, box, 0.0);
  int num_tested = 0;
  for (const CityBuilding& building : city.BuildingsIn(BoxAroundPoint({0.0, 0.0}, 40.0))) {
    const Eigen::Vector2d middle = 0.5 * (building.corners[0] + building.corners[1]);
    const Eigen::Vector2d way = building.corners[1] - building.corners[0];
    const Eigen::Vector2d outwards = Eigen::Vector2d(way.y(), -way.x()).normalized();
    const double z_m = building.ground_m + 2.0;
    const auto at = [&](double out_m, double height_m) {
      const Eigen::Vector2d place = middle + out_m * outwards;
      return Eigen::Vector3d(place.x(), place.y(), height_m);
    };
    const Eigen::Vector3d camera = at(4.0, z_m);
    EXPECT_FALSE(region.IsHidden(camera, at(0.0, z_m + 1.0)));
    EXPECT_FALSE(region.IsHidden(camera, at(0.0, building.top_m - 0.1)));
    EXPECT_TRUE(region.IsHidden(camera, at(-25.0, z_m)));
    // Far above the roofs one sees across.
    EXPECT_FALSE(region.IsHidden(at(4.0, building.top_m + 30.0), at(-25.0, building.top_m + 30.0)));
    // What sits a little behind the plane of the wall is still seen at an angle.
    const Eigen::Vector2d aside = middle + 5.0 * outwards + 6.0 * way.normalized();
    EXPECT_FALSE(region.IsHidden({aside.x(), aside.y(), z_m}, at(-0.03, building.ground_m + 3.0)));
    ++num_tested;
  }
  EXPECT_GT(num_tested, 5);
}

TEST(CityRegion, LinesOfSightAreJudgedAsByTestingEveryBuilding) {
  const City city(Sparse(CityCharacter::kSuburb));
  const CityBox box = BoxAroundPoint(Eigen::Vector2d::Zero(), 120.0);
  const CityRegion region(city, box, 0.0);
  const std::vector<CityBuilding> buildings = city.BuildingsIn(box);
  int num_hidden = 0;
  constexpr int kCount = 2000;
  for (int i = 0; i < kCount; ++i) {
    HashedRandom random(i);
    const auto draw = [&] {
      return Eigen::Vector3d(random.Uniform(-110.0, 110.0), random.Uniform(-110.0, 110.0),
                             random.Uniform(0.0, 12.0));
    };
    const Eigen::Vector3d from = draw(), to = draw();
    bool is_hidden = false;
    const double end = 1.0 - 0.2 / (to - from).norm();
    for (double t = 0.0; t < end && !is_hidden; t += 1e-3) {
      const Eigen::Vector3d at = from + t * (to - from);
      is_hidden = std::any_of(buildings.begin(), buildings.end(), [&](const auto& building) {
        return at.z() < building.top_m - 0.05 && IsInside(building, at.head<2>(), 0.1);
      });
    }
    num_hidden += is_hidden;
    if (is_hidden) {
      EXPECT_TRUE(region.IsHidden(from, to));
    }
  }
  EXPECT_GT(num_hidden, kCount / 10);
  EXPECT_LT(num_hidden, kCount * 9 / 10);
}

}  // namespace
}  // namespace cairn
