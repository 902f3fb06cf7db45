// Reads the place of a photo from its XMP. Private to core/images.
#ifndef CAIRN_CORE_IMAGES_XMP_POSITION_H_
#define CAIRN_CORE_IMAGES_XMP_POSITION_H_

#include <optional>
#include <string_view>

#include "core/geodesy.h"

namespace cairn {

struct XmpPosition {
  Geodetic position;  // The height is above mean sea level; 0 if there is none.
  bool has_altitude = false;
};

// The position in the properties exif:GPS... ("55,41.89N"), which editors write, or else in those
// of drones, drone-dji:Gps... ("+55.698"), as attributes or elements under their usual prefixes.
// Nothing if latitude or longitude is missing, malformed or out of range, for 0, 0, and for
// positions that are marked as void. Takes time linear in the length of the text and allocates
// nothing.
std::optional<XmpPosition> ReadXmpPosition(std::string_view xmp);

}  // namespace cairn

#endif  // CAIRN_CORE_IMAGES_XMP_POSITION_H_
