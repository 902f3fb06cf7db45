#include "core/wire/stated_camera.h"

#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "core/error.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;

constexpr char kUnknown[] = "unknown";

CameraModel ReadModel(const JsonReader& model) {
  const std::string& name = model.String(64);
  try {
    return CameraModelFromName(name);
  } catch (const Error& e) {
    model.Fail(e.what());
  }
}

// Replaces the focal length in the parameters, which does not count.
Camera WithoutFocal(const Camera& camera) {
  const double unknown_px = CameraOfUnknownFocal(camera.width_px(), camera.height_px()).focal_px();
  return WithFocalScaled(camera, unknown_px / camera.focal_px());
}

bool SaysUnknown(const JsonReader& focal_length) {
  if (focal_length.String() != kUnknown) {
    focal_length.Fail("must be \"unknown\" if present",
                      "put a known focal length in modelParams and its uncertainty in "
                      "focalLengthSigma");
  }
  return true;
}

Json ImageSizeJson(const Camera& camera) {
  return Json::array({camera.width_px(), camera.height_px()});
}

}  // namespace

ImageSize ReadImageSize(const JsonReader& size) {
  const std::vector<JsonReader> sides = size.Elements(2, 2);
  return {static_cast<int>(sides[0].Integer(1, 100'000)),
          static_cast<int>(sides[1].Integer(1, 100'000))};
}

StatedCamera ReadCameraParts(const std::optional<JsonReader>& model, const ImageSize& size,
                             const std::optional<JsonReader>& params) {
  const auto [width_px, height_px] = size;
  if (params) {
    if (!model) {
      params->Fail("have no model", "set model, for example to SIMPLE_PINHOLE");
    }
    const CameraModel camera_model = ReadModel(*model);
    const std::vector<double> numbers = params->Numbers(0, 16);
    try {
      return {Camera(camera_model, width_px, height_px, numbers), std::nullopt};
    } catch (const Error& e) {
      params->Fail(e.what());
    }
  }
  if (model && IsFisheye(ReadModel(*model))) {
    model->Fail("needs modelParams, because the server does not guess fisheye parameters");
  }
  return {CameraOfUnknownFocal(width_px, height_px), FocalPrior{.with_distortion = true}};
}

StatedCamera ReadStatedCamera(const JsonReader& camera) {
  camera.RequireOnly({"model", "size", "modelParams", "focalLength", "focalLengthSigma"});
  StatedCamera stated = ReadCameraParts(camera.Find("model"), ReadImageSize(camera.At("size")),
                                        camera.Find("modelParams"));
  const auto focal_length = camera.Find("focalLength");
  const auto sigma = camera.Find("focalLengthSigma");
  const bool is_unknown = focal_length && SaysUnknown(*focal_length);
  if (sigma && (is_unknown || !camera.Has("modelParams"))) {
    sigma->Fail("needs a focal length in modelParams",
                "add modelParams, or leave out focalLengthSigma");
  }
  if (sigma) {
    stated.focal =
        FocalPrior{.log_sigma = sigma->Number(FocalPrior::kMinLogSigma, FocalPrior::kMaxLogSigma)};
  } else if (is_unknown && camera.Has("modelParams")) {
    stated = {WithoutFocal(stated.camera), FocalPrior()};
  }
  return stated;
}

Json StatedCameraJson(const Camera& camera, const std::optional<FocalPrior>& focal) {
  if (focal && focal->with_distortion) {
    return {{"size", ImageSizeJson(camera)}, {"focalLength", kUnknown}};
  }
  Json json = CameraJson(camera);
  if (focal) {
    json["focalLengthSigma"] = focal->log_sigma;
  }
  return json;
}

Json CameraJson(const Camera& camera) {
  return {{"model", CameraModelName(camera.model())},
          {"size", ImageSizeJson(camera)},
          {"modelParams", camera.params()}};
}

Camera ReadKnownCamera(const JsonReader& camera) {
  for (const char* member : {"focalLength", "focalLengthSigma"}) {
    if (const auto uncertain = camera.Find(member)) {
      uncertain->Fail("is not allowed in a rig: its cameras need known focal lengths");
    }
  }
  camera.RequireOnly({"model", "size", "modelParams"});
  const JsonReader model = camera.At("model");
  const JsonReader size = camera.At("size");
  return ReadCameraParts(model, ReadImageSize(size), camera.At("modelParams")).camera;
}

}  // namespace cairn
