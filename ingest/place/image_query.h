// A photo of a reconstruction as a question to a map.
#ifndef CAIRN_INGEST_PLACE_IMAGE_QUERY_H_
#define CAIRN_INGEST_PLACE_IMAGE_QUERY_H_

#include <string>

#include "core/geodesy.h"
#include "core/scene/reconstruction.h"
#include "engine/query/localize_query.h"

namespace cairn {

// New ground that resembles the map gets a weak answer now and then, so weak answers to photos that
// are not expected there do not count.
inline constexpr double kSureConfidence = 0.9;

// The query has the features and the camera of the image, and no gravity. `codec` is the map's
// (Codebook::CodecName), `about` a position of this accuracy with a height above the ellipsoid.
LocalizeQuery QueryOfImage(const Reconstruction& reconstruction, int image_idx,
                           const Geodetic& about, double accuracy_m, const std::string& codec);

}  // namespace cairn

#endif  // CAIRN_INGEST_PLACE_IMAGE_QUERY_H_
