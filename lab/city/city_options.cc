#include "lab/city/city_options.h"

#include <array>
#include <cmath>

#include "core/error.h"
#include "core/require.h"

namespace cairn {
namespace {

constexpr double kSqMPerSqKm = 1e6;
constexpr double kMinAreaKm2 = 1e-4;
constexpr double kMaxAreaKm2 = 900.0;
constexpr double kMaxLatitudeDeg = 80.0;

struct CharacterFacts {
  CityCharacter character;
  const char* name;
  double repeated_share;
  double lat_deg, lon_deg, h_m;
  double relief_m;
};

constexpr std::array<CharacterFacts, 4> kCharacters = {{
    {CityCharacter::kOldTown, "old-town", 0.35, 47.3769, 8.5417, 456.0, 25.0},
    {CityCharacter::kGrid, "grid", 0.45, 41.3917, 2.1649, 80.0, 8.0},
    {CityCharacter::kSuburb, "suburb", 0.30, 51.4800, 12.0000, 140.0, 15.0},
    {CityCharacter::kHighRise, "high-rise", 0.60, 64.1450, -21.9400, 85.0, 20.0},
}};

const CharacterFacts& FactsOf(CityCharacter character) {
  return kCharacters[static_cast<size_t>(character)];
}

}  // namespace

const char* CityCharacterName(CityCharacter character) { return FactsOf(character).name; }

CityCharacter CityCharacterFromName(const std::string& name) {
  std::string names;
  for (const CharacterFacts& facts : kCharacters) {
    if (name == facts.name) {
      return facts.character;
    }
    names += names.empty() ? facts.name : std::string(", ") + facts.name;
  }
  throw Error(ErrorCode::kInvalidArgument,
              "character '" + name + "' is unknown; characters are " + names);
}

double CityOptions::SideM() const { return std::sqrt(area_km2 * kSqMPerSqKm); }

double CityOptions::RepeatedShare() const {
  return repeated_share < 0.0 ? FactsOf(character).repeated_share : repeated_share;
}

void CityOptions::Validate() const {
  RequireWithin("city.center latitude in degrees", center.lat_deg(), -kMaxLatitudeDeg,
                kMaxLatitudeDeg);
  RequireWithin("city.center longitude in degrees", center.lon_deg(), -180.0, 180.0);
  // Limits of what a map can hold; see PlaceSession.
  RequireWithin("city.center height in meters", center.h_m, -400.0, 3000.0);
  RequireWithin("city.area_km2", area_km2, kMinAreaKm2, kMaxAreaKm2);
  RequireWithin("city.relief_m", relief_m, 0.0, 300.0);
  RequireWithin("city.min_landmark_size_m", min_landmark_size_m, 0.01, 0.5);
  RequireWithin("city.repeated_share", RepeatedShare(), 0.0, 0.95);
  RequireWithin("city.num_styles", num_styles, 1, 10'000);
  RequireWithin("city.lifetime_factor", lifetime_factor, 0.01, 1000.0);
}

CityOptions CityPreset(CityCharacter character) {
  const CharacterFacts& facts = FactsOf(character);
  CityOptions options;
  options.character = character;
  options.center = Geodetic::FromDegrees(facts.lat_deg, facts.lon_deg, facts.h_m);
  options.relief_m = facts.relief_m;
  return options;
}

}  // namespace cairn
