// The module cairn._cairn, which the package cairn exports.
#include <pybind11/pybind11.h>

#include <map>
#include <string>

#include "core/logging.h"
#include "python/arguments.h"
#include "python/building.h"
#include "python/camera.h"
#include "python/client.h"
#include "python/docs.h"
#include "python/errors.h"
#include "python/evaluating.h"
#include "python/features.h"
#include "python/fusion.h"
#include "python/map.h"
#include "python/query.h"
#include "python/result.h"

namespace cairn::python {
namespace {

void SetLevel(const py::object& level) {
  static const std::map<std::string, LogLevel> kLevels = {{"debug", LogLevel::kDebug},
                                                          {"info", LogLevel::kInfo},
                                                          {"warning", LogLevel::kWarning},
                                                          {"error", LogLevel::kError},
                                                          {"off", LogLevel::kOff}};
  const auto found = kLevels.find(TextOf("level", level));
  if (found == kLevels.end()) {
    RefuseArgument("level", "must be 'debug', 'info', 'warning', 'error' or 'off'");
  }
  SetLogLevel(found->second);
}

// People know the classes as members of the package.
void NamePackage(const py::module_& module) {
  for (const auto& [name, member] : module.attr("__dict__").cast<py::dict>()) {
    if (py::isinstance<py::type>(member) && !member.is(module.attr("Error"))) {
      py::setattr(member, "__module__", py::str("cairn"));
    }
  }
}

// pybind11 reads numpy's own structures; before 2.12 it knows only those of numpy 1.
void RequireKnownNumpy() {
#if PYBIND11_VERSION_HEX < 0x020C0000
  const auto version = py::module_::import("numpy").attr("__version__").cast<std::string>();
  if (std::stoi(version) >= 2) {
    throw py::import_error("cairn was built with pybind11 " PYBIND11_TOSTRING(
        PYBIND11_VERSION_MAJOR) "." PYBIND11_TOSTRING(PYBIND11_VERSION_MINOR) ", which knows numpy "
        "1 only, and this is numpy " + version +
        ": install numpy<2, or build cairn with pybind11 2.12 or newer");
  }
#endif
}

}  // namespace
}  // namespace cairn::python

PYBIND11_MODULE(_cairn, module) {
  namespace py = pybind11;
  using namespace cairn::python;  // NOLINT(google-build-using-namespace)
  module.doc() = "The compiled part of the package cairn.";
  py::options options;
  RequireKnownNumpy();
  options.disable_function_signatures();  // The docstrings begin with them.
  module.attr("__version__") = CAIRN_VERSION;
  cairn::SetLogLevel(cairn::LogLevel::kWarning);
  BindErrors(&module);
  BindCamera(&module);
  BindFeatures(&module);
  BindQuery(&module);
  BindResult(&module);
  BindMap(&module);
  BindBuilding(&module);
  BindEvaluating(&module);
  BindClient(&module);
  BindFusion(&module);
  module.def("set_log_level", &SetLevel, py::arg("level"), docs::kSetLogLevel);
  NamePackage(module);
}
