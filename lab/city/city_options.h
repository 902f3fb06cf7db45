// Options of the simulated city; docs/simulated_city.md describes them.
#ifndef CAIRN_LAB_CITY_CITY_OPTIONS_H_
#define CAIRN_LAB_CITY_CITY_OPTIONS_H_

#include <cstdint>
#include <string>

#include "core/geodesy.h"

namespace cairn {

// The kind of streets, blocks and houses.
enum class CityCharacter {
  kOldTown,   // Narrow crooked streets, closed rows of houses with four floors.
  kGrid,      // A regular grid of wide streets, closed rows with six floors.
  kSuburb,    // Detached houses behind gardens, trees.
  kHighRise,  // Wide streets, towers up to 120 m with facades that repeat.
};

// "old-town", "grid", "suburb", "high-rise".
const char* CityCharacterName(CityCharacter character);
// Throws Error(kInvalidArgument) that lists the names.
CityCharacter CityCharacterFromName(const std::string& name);

struct CityOptions {
  // Center of the city: the middle of a street at ground level, and the origin of the frame `site`.
  Geodetic center = Geodetic::FromDegrees(47.3769, 8.5417, 408.0);
  // Mapped area, in square kilometers, (0, 900]: a square around the center. If the square is wider
  // than 30 km, a plane frame no longer represents the ground well. Streets continue outside the
  // square.
  double area_km2 = 0.0225;
  CityCharacter character = CityCharacter::kOldTown;
  // Height from the lowest to the highest ground, meters, [0, 300].
  double relief_m = 12.0;
  // Size of the smallest physical keypoint, meters, [0.01, 0.5]. Halving it gives four times as
  // many landmarks; the cost grows in proportion.
  double min_landmark_size_m = 0.03;
  // Share of the facade landmarks that belong to an ornament which repeats along the facade, [0,
  // 0.95]. If negative, the character's own share (0.3 to 0.6) is used.
  double repeated_share = -1.0;
  // Number of facade styles in town, [1, 10000]. How often a style occurs falls with its rank
  // (Zipf's law).
  int num_styles = 40;
  // Factor on the lifetimes of things, [0.01, 1000]. 1 is an estimate for a European town:
  // structure 40 years, paint 8, shop fronts and posters 0.7, leaves 0.25, parked cars an hour.
  double lifetime_factor = 1.0;
  uint64_t seed = 1;

  // Side of the square, meters.
  double SideM() const;
  // Returns repeated_share or, if that is negative, the character's own share.
  double RepeatedShare() const;
  // Throws Error(kInvalidArgument) that names the field, its value and its range.
  void Validate() const;
};

// Options for a city of the given character at a suitable place: Zurich, Barcelona, a suburb of
// Halle across the border of UTM zones 32 and 33 (12 degrees east), or towers at 64 degrees north
// (Reykjavik).
CityOptions CityPreset(CityCharacter character);

}  // namespace cairn

#endif  // CAIRN_LAB_CITY_CITY_OPTIONS_H_
