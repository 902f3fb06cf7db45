#include "python/camera.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <pybind11/stl.h>

#include <utility>
#include <vector>

#include "core/error.h"
#include "core/images/exif.h"
#include "core/images/gray_image.h"
#include "core/images/orient_image.h"
#include "core/images/photo_camera.h"
#include "python/arguments.h"
#include "python/docs.h"

namespace cairn::python {
namespace {

std::vector<double> ParamsOf(py::handle value) {
  std::vector<double> params;
  if (!py::isinstance<py::iterable>(value) || py::isinstance<py::str>(value)) {
    RefuseArgument("params", "must be a sequence of numbers");
  }
  for (const py::handle param : value) {
    params.push_back(NumberOf("params", param, -1e12, 1e12));
  }
  return params;
}

std::optional<FocalPrior> FocalOf(py::handle sigma, const Camera& camera) {
  if (sigma.is_none()) {
    return std::nullopt;
  }
  FocalPrior focal;
  focal.log_sigma =
      NumberOf("focal_sigma", sigma, FocalPrior::kMinLogSigma, FocalPrior::kMaxLogSigma);
  focal.Validate(camera);
  return focal;
}

StatedCamera MakeCamera(const py::object& model, const py::object& size, const py::object& params,
                        const py::object& focal_sigma) {
  const auto [width_px, height_px] = SizeOf("size", size);
  StatedCamera stated;
  stated.camera =
      Camera(CameraModelFromName(TextOf("model", model)), width_px, height_px, ParamsOf(params));
  stated.focal = FocalOf(focal_sigma, stated.camera);
  return stated;
}

StatedCamera UnknownCamera(const py::object& size) {
  const auto [width_px, height_px] = SizeOf("size", size);
  return {CameraOfUnknownFocal(width_px, height_px), FocalPrior{.with_distortion = true}};
}

StatedCamera CameraFromExif(const py::object& path_argument) {
  const std::string path = PathOf("path", path_argument);
  const py::gil_scoped_release release;
  try {
    const ExifInfo exif = ReadExif(ReadImageBytes(path));
    int width_px = exif.width_px, height_px = exif.height_px;
    if (SwapsSides(exif.orientation)) {
      std::swap(width_px, height_px);
    }
    PhotoCamera of_photo = CameraOfPhoto(exif, width_px, height_px);
    return {std::move(of_photo.camera), of_photo.focal};
  } catch (const Error& error) {
    const std::string message = error.what();
    throw Error(error.code(),
                message.find(path) == std::string::npos ? path + ": " + message : message);
  }
}

std::string RepresentCamera(const StatedCamera& stated) {
  const Camera& camera = stated.camera;
  return fmt::format("cairn.Camera('{}', ({}, {}), [{}]{})", CameraModelName(camera.model()),
                     camera.width_px(), camera.height_px(), fmt::join(camera.params(), ", "),
                     stated.focal ? fmt::format(", focal_sigma={}", stated.focal->log_sigma) : "");
}

}  // namespace

std::array<int, 2> SizeOf(const std::string& argument, py::handle value) {
  if (!py::isinstance<py::sequence>(value) || py::len(value) != 2) {
    RefuseArgument(argument, "must be (width, height) in pixels");
  }
  const auto pair = py::reinterpret_borrow<py::sequence>(value);
  return {static_cast<int>(IntegerOf(argument, pair[0], 1, Camera::kMaxSidePx)),
          static_cast<int>(IntegerOf(argument, pair[1], 1, Camera::kMaxSidePx))};
}

std::optional<StatedCamera> CameraOf(const std::string& argument, py::handle value) {
  if (value.is_none()) {
    return std::nullopt;
  }
  if (!py::isinstance<StatedCamera>(value)) {
    RefuseArgument(argument,
                   fmt::format("must be a cairn.Camera, not {}", Py_TYPE(value.ptr())->tp_name));
  }
  return value.cast<StatedCamera>();
}

void BindCamera(py::module_* module) {
  using py::arg;
  py::class_<StatedCamera>(*module, "Camera", docs::kCamera)
      .def(py::init(&MakeCamera), arg("model"), arg("size"), arg("params"), py::kw_only(),
           arg("focal_sigma") = py::none())
      .def_static("from_exif", &CameraFromExif, arg("path"), docs::kCameraFromExif)
      .def_static("unknown", &UnknownCamera, arg("size"), docs::kCameraUnknown)
      .def_property_readonly(
          "model",
          [](const StatedCamera& stated) { return CameraModelName(stated.camera.model()); },
          "COLMAP's name of the model.")
      .def_property_readonly(
          "size",
          [](const StatedCamera& stated) {
            return py::make_tuple(stated.camera.width_px(), stated.camera.height_px());
          },
          "(width, height), pixels.")
      .def_property_readonly(
          "params",
          [](const StatedCamera& stated) -> py::tuple {
            return py::tuple(py::cast(stated.camera.params()));
          },
          "Parameters in COLMAP's order, pixels.")
      .def_property_readonly(
          "focal_sigma",
          [](const StatedCamera& stated) -> py::object {
            return stated.focal ? py::cast(stated.focal->log_sigma) : py::none();
          },
          "Relative standard deviation of the focal length, or None if it is taken as stated.")
      .def("__repr__", &RepresentCamera);
}

}  // namespace cairn::python
