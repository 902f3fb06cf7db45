// cairn.evaluate: measures a map against known poses, as `cairn eval` does.
#ifndef CAIRN_PYTHON_EVALUATING_H_
#define CAIRN_PYTHON_EVALUATING_H_

#include "python/errors.h"

namespace cairn::python {

// The keywords of evaluate have their defaults in cairn/_report.py.
void BindEvaluating(py::module_* module);

}  // namespace cairn::python

#endif  // CAIRN_PYTHON_EVALUATING_H_
