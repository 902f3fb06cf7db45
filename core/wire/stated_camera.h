// The camera of a request and the uncertainty of its focal length.
#ifndef CAIRN_CORE_WIRE_STATED_CAMERA_H_
#define CAIRN_CORE_WIRE_STATED_CAMERA_H_

#include <nlohmann/json_fwd.hpp>
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
  std::optional<FocalPrior> focal;  // Empty if the focal length is known.
};

// Reads an object with `size` ([width, height]) and, as far as the client knows them, `model`,
// `modelParams` (the parameters, which need a model), and `focalLength` ("unknown") or
// `focalLengthSigma` (relative). Without parameters, focal length and distortion are unknown. With
// focalLength "unknown", all parameters count except the focal length. Throws JsonError with the
// JSON pointer of the member at fault.
StatedCamera ReadStatedCamera(const JsonReader& camera);

// What ReadStatedCamera reads. If the distortion is unknown too, only the size is stated. A focal
// prior that comes with parameters is stated as a standard deviation, however large, because the
// reader replaces an "unknown" focal length by its own guess.
nlohmann::ordered_json StatedCameraJson(const Camera& camera,
                                        const std::optional<FocalPrior>& focal);

// An object with `model`, `size` and `modelParams`. The focal length must be known.
nlohmann::ordered_json CameraJson(const Camera& camera);
Camera ReadKnownCamera(const JsonReader& camera);

// Reads members that may come from different objects. Without `params`, the camera is unknown.
StatedCamera ReadCameraParts(const std::optional<JsonReader>& model, const ImageSize& size,
                             const std::optional<JsonReader>& params);
// Reads [width, height].
ImageSize ReadImageSize(const JsonReader& size);

}  // namespace cairn

#endif  // CAIRN_CORE_WIRE_STATED_CAMERA_H_
