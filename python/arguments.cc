#include "python/arguments.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <vector>

#include "cli/options/read_options.h"
#include "core/angles.h"
#include "core/error.h"
#include "core/parallel_for.h"
#include "python/arrays.h"

namespace cairn::python {
namespace {

// How far a rotation may be from one: what float32 leaves of it.
constexpr double kRotationTolerance = 1e-5;

std::string TypeName(py::handle value) { return Py_TYPE(value.ptr())->tp_name; }

// All numbers of something that numpy makes an array of; nothing if it does not.
std::optional<py::array_t<double>> NumbersOf(py::handle value) {
  using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;
  if (py::isinstance<py::str>(value) || value.is_none()) {
    return std::nullopt;
  }
  const Numbers numbers = Numbers::ensure(value);
  if (!numbers) {
    PyErr_Clear();
    return std::nullopt;
  }
  const double* data = numbers.data();
  for (py::ssize_t i = 0; i < numbers.size(); ++i) {
    if (!std::isfinite(data[i])) {
      return std::nullopt;
    }
  }
  return numbers;
}

}  // namespace

std::string TextOf(const std::string& argument, py::handle value) {
  if (!py::isinstance<py::str>(value)) {
    RefuseArgument(argument, fmt::format("must be a str, not {}", TypeName(value)));
  }
  return value.cast<std::string>();
}

bool IsPath(py::handle value) {
  return py::isinstance<py::str>(value) || py::hasattr(value, "__fspath__");
}

std::string PathOf(const std::string& argument, py::handle value) {
  if (!IsPath(value)) {
    RefuseArgument(argument, fmt::format("must be a path, not {}", TypeName(value)));
  }
  const py::bytes encoded = py::module_::import("os").attr("fsencode")(value);
  const std::string path = encoded;
  if (path.empty() || path.find('\0') != std::string::npos) {
    RefuseArgument(argument, "must be a path; it is empty or has a zero byte");
  }
  return path;
}

std::string PathOrEmpty(const std::string& argument, py::handle value) {
  return value.is_none() ? std::string() : PathOf(argument, value);
}

double NumberOf(const std::string& argument, py::handle value, double min, double max) {
  const double number =
      py::isinstance<py::str>(value) ? std::nan("") : PyFloat_AsDouble(value.ptr());
  if (PyErr_Occurred() != nullptr) {
    PyErr_Clear();
    RefuseArgument(argument, fmt::format("must be a number, not {}", TypeName(value)));
  }
  if (!(number >= min && number <= max)) {
    RefuseArgument(argument, fmt::format("{} must be a number in [{}, {}]",
                                         py::str(value).cast<std::string>(), min, max));
  }
  return number;
}

double PositiveOf(const std::string& argument, py::handle value) {
  return NumberOf(argument, value, std::numeric_limits<double>::min(), 1e12);
}

int64_t IntegerOf(const std::string& argument, py::handle value, int64_t min, int64_t max) {
  const auto index = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
  if (!index) {
    PyErr_Clear();
    RefuseArgument(argument, fmt::format("must be a whole number, not {}", TypeName(value)));
  }
  const int64_t number = PyLong_AsLongLong(index.ptr());
  const bool overflows = PyErr_Occurred() != nullptr;
  PyErr_Clear();
  if (overflows || number < min || number > max) {
    RefuseArgument(argument, fmt::format("{} must be in [{}, {}]",
                                         py::str(value).cast<std::string>(), min, max));
  }
  return number;
}

bool FlagOf(const std::string& argument, py::handle value) {
  if (!py::isinstance<py::bool_>(value)) {
    RefuseArgument(argument, fmt::format("must be True or False, not {}", TypeName(value)));
  }
  return value.cast<bool>();
}

int ThreadsOf(const std::string& argument, py::handle value) {
  const auto threads = static_cast<int>(IntegerOf(argument, value, 0, 1024));
  return threads == 0 ? NumCores() : threads;
}

Eigen::Vector3d VectorOf(const std::string& argument, py::handle value) {
  const auto numbers = NumbersOf(value);
  if (!numbers || numbers->ndim() != 1 || numbers->size() != 3) {
    RefuseArgument(argument, "must be three finite numbers");
  }
  return Eigen::Map<const Eigen::Vector3d>(numbers->data());
}

Eigen::Vector3d DirectionOf(const std::string& argument, py::handle value) {
  const Eigen::Vector3d vector = VectorOf(argument, value);
  if (vector.isZero(0.0)) {
    RefuseArgument(argument, "must not be zero");
  }
  return vector.stableNormalized();
}

Rigid3d PoseOf(const std::string& argument, py::handle value) {
  const auto numbers = NumbersOf(value);
  if (!numbers || numbers->ndim() != 2 || numbers->shape(0) != 4 || numbers->shape(1) != 4) {
    RefuseArgument(argument, "must be a 4 x 4 matrix of finite numbers");
  }
  const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> matrix(numbers->data());
  const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
  if (matrix.row(3) != Eigen::RowVector4d(0, 0, 0, 1)) {
    RefuseArgument(argument, "the last row must be 0, 0, 0, 1");
  }
  if (!(rotation * rotation.transpose()).isIdentity(kRotationTolerance) ||
      rotation.determinant() < 0.0) {
    RefuseArgument(argument, "the upper left 3 x 3 matrix is no rotation");
  }
  return {rotation, matrix.topRightCorner<3, 1>()};
}

Geodetic PositionOf(const std::string& argument, py::handle value) {
  const auto numbers = NumbersOf(value);
  if (!numbers || numbers->ndim() != 1 || numbers->size() < 2 || numbers->size() > 3) {
    RefuseArgument(argument,
                   "must be (latitude, longitude) or (latitude, longitude, height), degrees and "
                   "meters");
  }
  const double* data = numbers->data();
  const Geodetic position =
      Geodetic::FromDegrees(data[0], data[1], numbers->size() == 3 ? data[2] : 0.0);
  try {
    ValidateGeodetic(position, argument.c_str());
  } catch (const Error& error) {
    throw Error(ErrorCode::kInvalidArgument, error.what());
  }
  return position;
}

GeoBox BoxOf(const std::string& argument, py::handle value) {
  const auto numbers = NumbersOf(value);
  if (!numbers || numbers->ndim() != 1 || numbers->size() != 4) {
    RefuseArgument(argument, "must be (west, south, east, north) in degrees");
  }
  const double* data = numbers->data();
  const auto is_within = [](double angle_deg, double max_deg) {
    return std::abs(angle_deg) <= max_deg;
  };
  if (!is_within(data[0], 180.0) || !is_within(data[2], 180.0) || !is_within(data[1], 90.0) ||
      !is_within(data[3], 90.0) || data[1] > data[3]) {
    RefuseArgument(argument,
                   "must be (west, south, east, north) in degrees: longitudes within 180, "
                   "latitudes within 90, the south first");
  }
  return {.south_rad = data[1] * kRadPerDeg,
          .west_rad = data[0] * kRadPerDeg,
          .north_rad = data[3] * kRadPerDeg,
          .east_rad = data[2] * kRadPerDeg};
}

std::string OptionsJsonOf(py::handle value) {
  if (!py::isinstance<py::dict>(value)) {
    RefuseArgument("options", fmt::format("must be a dict or the path of a JSON file, not {}",
                                          TypeName(value)));
  }
  try {
    return py::module_::import("cairn._support").attr("options_as_json")(value).cast<std::string>();
  } catch (py::error_already_set& error) {
    if (!error.matches(PyExc_TypeError) && !error.matches(PyExc_ValueError)) {
      throw;
    }
    RefuseArgument("options", py::str(error.value()).cast<std::string>());
  }
}

CairnOptions OptionsOf(py::handle value) {
  CairnOptions options;
  if (value.is_none()) {
    return options;
  }
  if (IsPath(value)) {
    ReadOptionsFile(PathOf("options", value), &options);
    return options;
  }
  const std::string json = OptionsJsonOf(value);
  try {
    ReadOptions(json, &options);
  } catch (const Error& error) {
    throw Error(error.code(), std::string("options: ") + error.what());
  }
  return options;
}

}  // namespace cairn::python
