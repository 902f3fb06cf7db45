// Extracts features from the images of a request.
#ifndef CAIRN_HTTP_SERVICE_IMAGE_FEATURES_H_
#define CAIRN_HTTP_SERVICE_IMAGE_FEATURES_H_

#include <vector>

#include "core/features.h"
#include "core/features/feature_extractor.h"
#include "core/images/gray_image.h"
#include "http/json/localize_request.h"
#include "http/json/localize_response.h"

namespace cairn {

struct ImageFeatures {
  // Of the query's camera and of the other cameras of its rig, as LocalizeRequest::images. Fewer if
  // the work was stopped.
  std::vector<FeatureSet> of_image;
  ServerTimes times;  // Of the steps that were completed.
  bool was_stopped = false;
};

// Decodes the request's images, turns them as their `orientation` states, and extracts the features
// of each. The content of an image identifies JPEG, PNG and PNM; the name of the format identifies
// GRAY8 and RGBA32. Stops once `limits.should_stop` returns true, which is called while an image is
// decoded and while its features are extracted. Throws
// - HttpError kInvalidImage if an image does not decode or does not have the size of its camera,
// - HttpError kImageTooLarge, before decoding, if an image has more pixels than `limits` allow.
ImageFeatures ExtractImageFeatures(const LocalizeRequest& request,
                                   const FeatureExtractor& extractor,
                                   const ImageDecodeLimits& limits);

}  // namespace cairn

#endif  // CAIRN_HTTP_SERVICE_IMAGE_FEATURES_H_
