// Reads the camera of a request and the uncertainty of its focal length.
#ifndef CAIRN_HTTP_JSON_STATED_CAMERA_H_
#define CAIRN_HTTP_JSON_STATED_CAMERA_H_

#include <optional>

#include "core/camera.h"
#include "core/focal_length.h"
#include "core/wire/json_reader.h"

namespace cairn {

struct ImageSize {
  int width_px = 0, height_px = 0;
};

struct StatedCamera {
  Camera camera;
  std::optional<FocalPrior> focal;  // Same meaning as LocalizeQuery::focal.
};

// Reads an object with `size` ([width, height]) and, as far as the client knows them, `model`,
// `modelParams` (the parameters, which need a model), and `focalLength` ("unknown") or
// `focalLengthSigma` (relative). Without parameters, focal length and distortion are unknown. With
// focalLength "unknown", all parameters count except the focal length. Throws JsonError with the
// JSON pointer of the member at fault.
StatedCamera ReadStatedCamera(const JsonReader& camera);

// Reads an object with `model`, `size` and `modelParams`. The focal length must be known.
Camera ReadKnownCamera(const JsonReader& camera);

// Reads members that may come from different objects. Without `params`, the camera is unknown.
StatedCamera ReadCameraParts(const std::optional<JsonReader>& model, const ImageSize& size,
                             const std::optional<JsonReader>& params);
// Reads [width, height].
ImageSize ReadImageSize(const JsonReader& size);

}  // namespace cairn

#endif  // CAIRN_HTTP_JSON_STATED_CAMERA_H_
