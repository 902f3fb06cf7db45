#include "python/errors.h"

#include <exception>

#include "core/error.h"

namespace cairn::python {
namespace {

constexpr char kErrorDoc[] =
    "A failure. The message names the argument, file, tile or field and says what to do.\n\n"
    "code: one of 'internal', 'invalid_argument', 'bad_input', 'not_found', 'conflict',\n"
    "'map_damaged', 'io', 'unavailable'.";

PyObject* error_type = nullptr;  // Lives as long as the interpreter.

void Translate(std::exception_ptr failure) {
  try {
    std::rethrow_exception(failure);
  } catch (const Error& error) {
    // A name of a file may be no UTF-8.
    const auto message = py::reinterpret_steal<py::object>(PyUnicode_DecodeUTF8(
        error.what(), static_cast<Py_ssize_t>(std::string(error.what()).size()), "replace"));
    py::object instance = py::reinterpret_borrow<py::object>(error_type)(message);
    instance.attr("code") = ErrorCodeName(error.code());
    PyErr_SetObject(error_type, instance.ptr());
  }
}

}  // namespace

void BindErrors(py::module_* module) {
  error_type = PyErr_NewExceptionWithDoc("cairn.Error", kErrorDoc, PyExc_Exception, nullptr);
  module->attr("Error") = py::reinterpret_borrow<py::object>(error_type);
  module->attr("Error").attr("code") = ErrorCodeName(ErrorCode::kInternal);
  py::register_local_exception_translator(&Translate);
}

void RefuseArgument(const std::string& argument, const std::string& problem) {
  throw Error(ErrorCode::kInvalidArgument, argument + ": " + problem);
}

py::str TextOut(std::string_view text) {
  PyObject* const decoded =
      PyUnicode_DecodeUTF8(text.data(), static_cast<Py_ssize_t>(text.size()), "surrogateescape");
  if (decoded == nullptr) {
    throw py::error_already_set();
  }
  return py::reinterpret_steal<py::str>(decoded);
}

}  // namespace cairn::python
