// Reads members of requests that several formats share. All functions throw JsonError with the
// pointer of the value at fault.
#ifndef CAIRN_HTTP_JSON_REQUEST_MEMBERS_H_
#define CAIRN_HTTP_JSON_REQUEST_MEMBERS_H_

#include <cstdint>
#include <optional>
#include <vector>

#include "core/geodesy.h"
#include "core/geoid.h"
#include "core/wire/json_reader.h"
#include "engine/query/localize_query.h"

namespace cairn {

// Phones report directions rounded and in single precision. This is how far their lengths may be
// from 1.
inline constexpr double kUnitNormTolerance = 0.02;
// The accuracy of a position whose source does not state one: 68 % radius, meters. A phone's GPS is
// within 5 m under the open sky; between houses, and while a camera app waits for its first fix,
// errors of some tens of meters are common.
inline constexpr double kUnknownAccuracyM = 25.0;

// Reads "ellipsoid" or "msl".
HeightReference ReadHeightReference(const JsonReader& name);
// Reads `camera` and `camFromFirst` of an element of `rig`. The result has no features.
RigCamera ReadRigCamera(const JsonReader& element);
// Decodes base64, with or without line breaks and padding.
std::vector<uint8_t> ReadBase64(const JsonReader& text);
// Reads and checks degrees and meters. Without `h` the height is 0.
Geodetic ReadGeodetic(const JsonReader& lat, const JsonReader& lon,
                      const std::optional<JsonReader>& h);

}  // namespace cairn

#endif  // CAIRN_HTTP_JSON_REQUEST_MEMBERS_H_
