// From the image of a request to features.
#ifndef CAIRN_HTTP_SERVICE_IMAGE_FEATURES_H_
#define CAIRN_HTTP_SERVICE_IMAGE_FEATURES_H_

#include "core/features.h"
#include "http/json/localize_request.h"
#include "http/json/localize_response.h"
#include "ingest/images/gray_image.h"

namespace cairn {

// Decodes the request's images (JPEG, PNG, PNM by their content; GRAY8 and RGBA32 by their name),
// turns them as their `orientation` says and gives the query the SIFT features of each camera, as
// `cairn localize` extracts them. Throws HttpError kInvalidImage if one does not decode or is not
// of its camera's size, kImageTooLarge before decoding if its header claims more than
// `limits.max_pixels`, and DecodingStopped once `limits.should_stop` says so, which is asked while
// an image is decoded and before each step. Adds to `times`.
void ExtractQueryFeatures(const ImageDecodeLimits& limits, LocalizeRequest* request,
                          ServerTimes* times);

}  // namespace cairn

#endif  // CAIRN_HTTP_SERVICE_IMAGE_FEATURES_H_
