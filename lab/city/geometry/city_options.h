// What the simulated city is like; docs/simulated_city.md describes it.
#ifndef CAIRN_LAB_CITY_GEOMETRY_CITY_OPTIONS_H_
#define CAIRN_LAB_CITY_GEOMETRY_CITY_OPTIONS_H_

#include <cstdint>
#include <string>

#include "core/geodesy.h"

namespace cairn {

// Which streets, blocks and houses there are.
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
  // The middle of the city, in the middle of a street and at the height of its ground: the origin
  // of the frame `site`.
  Geodetic center = Geodetic::FromDegrees(47.3769, 8.5417, 408.0);
  // Mapped area, square kilometres, (0, 900]: a square about the center. Beyond 30 km across, a
  // plane frame is no longer a good picture of the ground. Streets go on outside of it.
  double area_km2 = 0.0225;
  CityCharacter character = CityCharacter::kOldTown;
  // Between the lowest and the highest ground, metres, [0, 300].
  double relief_m = 12.0;
  // The smallest physical keypoint there is, metres, [0.01, 0.5]. There are four times as many
  // landmarks if it is halved; everything costs in proportion.
  double min_landmark_size_m = 0.03;
  // Share of the landmarks on facades that belong to an ornament which repeats along the facade,
  // [0, 0.95]; negative: what the character has (0.3 to 0.6).
  double repeated_share = -1.0;
  // Facade styles in town; how often each occurs falls with its rank as in Zipf's law. [1, 10000]
  int num_styles = 40;
  // Of how long things last, [0.01, 1000]; 1 is a guess at a European town: structure 40 years,
  // paint 8, shop fronts and posters 0.7, leaves 0.25, parked cars an hour.
  double lifetime_factor = 1.0;
  uint64_t seed = 1;

  // Of the square, metres.
  double SideM() const;
  // repeated_share, or what the character has.
  double RepeatedShare() const;
  // Throws Error(kInvalidArgument) naming the field, its value and its range.
  void Validate() const;
};

// A city of the given character at a place that suits it: Zurich, Barcelona, a suburb of Halle
// across the border of UTM zones 32 and 33 (12 degrees east), towers at 64 degrees north
// (Reykjavik).
CityOptions CityPreset(CityCharacter character);

}  // namespace cairn

#endif  // CAIRN_LAB_CITY_GEOMETRY_CITY_OPTIONS_H_
