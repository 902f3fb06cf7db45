// Extracts features from the images of a request.
#ifndef CAIRN_HTTP_SERVICE_IMAGE_FEATURES_H_
#define CAIRN_HTTP_SERVICE_IMAGE_FEATURES_H_

#include "core/features.h"
#include "core/features/feature_extractor.h"
#include "core/images/gray_image.h"
#include "http/json/localize_request.h"
#include "http/json/localize_response.h"

namespace cairn {

// Decodes the request's images, turns them as their `orientation` states, and stores the
// features of each camera in the query. The content of an image identifies JPEG, PNG and PNM; the
// name of the format identifies GRAY8 and RGBA32. Adds to `times`. Throws
// - HttpError kInvalidImage if an image does not decode or does not have the size of its camera,
// - HttpError kImageTooLarge, before decoding, if an image has more pixels than `limits` allow,
// - DecodingStopped once `limits.should_stop` returns true. `should_stop` is called while an image
//   is decoded and while its features are extracted.
void ExtractQueryFeatures(const ImageDecodeLimits& limits, const FeatureExtractor& extractor,
                          LocalizeRequest* request, ServerTimes* times);

}  // namespace cairn

#endif  // CAIRN_HTTP_SERVICE_IMAGE_FEATURES_H_
