// The camera of a request and how well its focal length is known.
#ifndef CAIRN_HTTP_JSON_STATED_CAMERA_H_
#define CAIRN_HTTP_JSON_STATED_CAMERA_H_

#include <optional>

#include "core/camera.h"
#include "core/focal_length.h"
#include "http/json/json_reader.h"

namespace cairn {

struct ImageSize {
  int width_px = 0, height_px = 0;
};

struct StatedCamera {
  Camera camera;
  std::optional<FocalPrior> focal;  // As LocalizeQuery::focal.
};

// Of an object with `size` ([width, height]) and, as far as the client knows them, `model`,
// `modelParams` (the parameters, which need a model), `focalLength` ("unknown") or
// `focalLengthSigma` (relative). Without parameters the focal length and the distortion are
// unknown; with an unknown focal length the parameters count but for it. Throws HttpError with the
// JSON pointer of what is wrong.
StatedCamera ReadStatedCamera(const JsonReader& camera);

// Of an object with `model`, `size` and `modelParams`, where the focal length has to be known.
Camera ReadKnownCamera(const JsonReader& camera);

// Of members that need not stand side by side; without `params` it is unknown.
StatedCamera ReadCameraParts(const std::optional<JsonReader>& model, const ImageSize& size,
                             const std::optional<JsonReader>& params);
// [width, height].
ImageSize ReadImageSize(const JsonReader& size);

}  // namespace cairn

#endif  // CAIRN_HTTP_JSON_STATED_CAMERA_H_
