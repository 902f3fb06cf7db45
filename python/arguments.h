// Arguments of Python, checked. Each function throws Error(kInvalidArgument) that names the
// argument if the value has another type or makes no sense.
#ifndef CAIRN_PYTHON_ARGUMENTS_H_
#define CAIRN_PYTHON_ARGUMENTS_H_

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include "cli/options/cairn_options.h"
#include "core/geodesy.h"
#include "core/rigid3.h"
#include "python/errors.h"

namespace cairn::python {

std::string TextOf(const std::string& argument, py::handle value);
// A str or an os.PathLike.
std::string PathOf(const std::string& argument, py::handle value);
// Empty for None.
std::string PathOrEmpty(const std::string& argument, py::handle value);
bool IsPath(py::handle value);

// A finite number in [min, max]; numpy's scalars are numbers.
double NumberOf(const std::string& argument, py::handle value, double min, double max);
double PositiveOf(const std::string& argument, py::handle value);
int64_t IntegerOf(const std::string& argument, py::handle value, int64_t min, int64_t max);
bool FlagOf(const std::string& argument, py::handle value);
// 0 means all cores.
int ThreadsOf(const std::string& argument, py::handle value);

// Three finite numbers, in anything that numpy takes for a vector.
Eigen::Vector3d VectorOf(const std::string& argument, py::handle value);
// A vector of any length but zero, made a unit vector.
Eigen::Vector3d DirectionOf(const std::string& argument, py::handle value);
// A 4 x 4 matrix of a rotation and a translation.
Rigid3d PoseOf(const std::string& argument, py::handle value);
// (latitude, longitude) in degrees, or with the height above the ellipsoid in meters.
Geodetic PositionOf(const std::string& argument, py::handle value);
// (west, south, east, north) in degrees, as in GeoJSON.
GeoBox BoxOf(const std::string& argument, py::handle value);

// The JSON text of a dict of options.
std::string OptionsJsonOf(py::handle value);
// None: the defaults. A dict, or the path of a JSON file: what --options of the command line takes.
CairnOptions OptionsOf(py::handle value);

}  // namespace cairn::python

#endif  // CAIRN_PYTHON_ARGUMENTS_H_
