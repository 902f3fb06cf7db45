// Turns failures into exceptions of Python.
#ifndef CAIRN_PYTHON_ERRORS_H_
#define CAIRN_PYTHON_ERRORS_H_

#include <pybind11/pybind11.h>

#include <string>
#include <string_view>

namespace cairn::python {

namespace py = pybind11;

// Makes cairn.Error. From then on, a cairn::Error that leaves a function of the module becomes one,
// whose `code` is the name of the ErrorCode.
void BindErrors(py::module_* module);

// Throws Error(kInvalidArgument) "<argument>: <problem>".
[[noreturn]] void RefuseArgument(const std::string& argument, const std::string& problem);

// A name from a map or from the disk for Python. Bytes that are not UTF-8 become what os.fsencode
// turns back into them.
py::str TextOut(std::string_view text);

}  // namespace cairn::python

#endif  // CAIRN_PYTHON_ERRORS_H_
