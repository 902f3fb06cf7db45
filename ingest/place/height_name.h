// What the name of a column says of the heights in it. Private to ingest/place.
#ifndef CAIRN_INGEST_PLACE_HEIGHT_NAME_H_
#define CAIRN_INGEST_PLACE_HEIGHT_NAME_H_

#include <optional>
#include <string_view>

#include "core/geoid.h"

namespace cairn {

struct HeightName {
  std::optional<HeightReference> reference;  // Empty if the name states none.
  bool in_meters = true;                     // False if the name states another unit.
};

// Reads names that consist of words for a height, its reference and its unit: "Altitude (MSL)",
// "height_orthometric", "alt_ft". Nothing for names with any other word, such as those of heights
// above the ground, and for names with two references. Case, blanks, signs and exiftool's groups
// ("EXIF:") do not count.
std::optional<HeightName> ReadHeightName(std::string_view column_name);

}  // namespace cairn

#endif  // CAIRN_INGEST_PLACE_HEIGHT_NAME_H_
