// Reads what the photos of a request say about themselves.
#ifndef CAIRN_HTTP_JSON_REQUEST_PHOTOS_H_
#define CAIRN_HTTP_JSON_REQUEST_PHOTOS_H_

#include <optional>

#include "core/images/exif.h"
#include "engine/query/localize_query.h"
#include "http/json/localize_request.h"

namespace cairn {

// The accuracy of a position whose source does not state one: 68 % radius, meters. A phone's GPS is
// within 5 m under the open sky; between houses, and while a camera app waits for its first fix,
// errors of some tens of meters are common.
inline constexpr double kUnknownAccuracyM = 25.0;

// The position in a photo's EXIF as a prior, with the stated error or else kUnknownAccuracyM, and
// with a height above the ellipsoid. EXIF does not state how accurate the height is, so the height
// does not count. Returns nothing if the photo has no position, or one with an error of more than
// PositionPrior::kMaxAccuracyM.
std::optional<PositionPrior> PriorOfPhoto(const ExifInfo& exif);

// The header of an answer that names the source of its prior, as PriorSourceName does; for clients
// of formats that cannot express it. Absent without a prior.
inline constexpr char kPriorHeader[] = "X-Cairn-Prior";
// The header that names the reason of an answer without a pose.
inline constexpr char kReasonHeader[] = "X-Cairn-Reason";

// Reads the headers of the request's images, but no pixels. Settles how each image is turned
// (LocalizeRequest::picture). Without a prior, takes the position in the EXIF of the first image as
// the prior, unless the request or `takes_exif_prior` forbids it. If the request states only the
// size of the camera, takes the focal length in the EXIF of the first image, if it has one
// (CameraOfPhoto). Does nothing for images that do
// not decode, which decoding reports, and for raw pixels. Takes time linear in the number of
// segments or chunks of the images.
void ReadPhotos(bool takes_exif_prior, LocalizeRequest* request);

}  // namespace cairn

#endif  // CAIRN_HTTP_JSON_REQUEST_PHOTOS_H_
