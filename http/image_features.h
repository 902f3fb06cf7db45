// From the image of a request to features.
#ifndef CAIRN_HTTP_IMAGE_FEATURES_H_
#define CAIRN_HTTP_IMAGE_FEATURES_H_

#include <cstdint>

#include "core/features.h"
#include "http/json/localize_request.h"
#include "http/json/localize_response.h"

namespace cairn {

// Decodes the request's images (JPEG, PNG, PNM by their content; GRAY8 and RGBA32 by their name),
// turns them as their `orientation` says and gives the query the SIFT features of each camera, as
// `cairn localize` extracts them. Throws HttpError kInvalidImage if one does not decode or is not
// of its camera's size, kImageTooLarge before decoding if its header claims more than `max_pixels`.
// Adds to `times`.
void ExtractQueryFeatures(int64_t max_pixels, LocalizeRequest* request, ServerTimes* times);

}  // namespace cairn

#endif  // CAIRN_HTTP_IMAGE_FEATURES_H_
