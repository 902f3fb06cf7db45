// cairn.Result: the answer to a query.
#ifndef CAIRN_PYTHON_RESULT_H_
#define CAIRN_PYTHON_RESULT_H_

#include "engine/query/localize_result.h"
#include "python/errors.h"

namespace cairn::python {

struct PythonResult {
  LocalizeResult result;
  double decode_seconds = 0.0;
  double extract_seconds = 0.0;
  double localize_seconds = 0.0;  // Of the localizer or of the server, with all of its stages.
};

void BindResult(py::module_* module);

}  // namespace cairn::python

#endif  // CAIRN_PYTHON_RESULT_H_
