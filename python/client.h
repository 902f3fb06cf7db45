// cairn.Client: a server that answers queries.
#ifndef CAIRN_PYTHON_CLIENT_H_
#define CAIRN_PYTHON_CLIENT_H_

#include "python/errors.h"

namespace cairn::python {

void BindClient(py::module_* module);

}  // namespace cairn::python

#endif  // CAIRN_PYTHON_CLIENT_H_
