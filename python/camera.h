// cairn.Camera.
#ifndef CAIRN_PYTHON_CAMERA_H_
#define CAIRN_PYTHON_CAMERA_H_

#include <array>
#include <optional>
#include <string>

#include "core/camera.h"
#include "core/focal_length.h"
#include "python/errors.h"

namespace cairn::python {

// A camera, and how well its focal length is known; without a prior, within 1 %.
struct StatedCamera {
  Camera camera;
  std::optional<FocalPrior> focal;
};

// (width, height) in pixels.
std::array<int, 2> SizeOf(const std::string& argument, py::handle value);

// None is no camera.
std::optional<StatedCamera> CameraOf(const std::string& argument, py::handle value);

void BindCamera(py::module_* module);

}  // namespace cairn::python

#endif  // CAIRN_PYTHON_CAMERA_H_
