// cairn.init, cairn.ingest and cairn.map.
#ifndef CAIRN_PYTHON_BUILDING_H_
#define CAIRN_PYTHON_BUILDING_H_

#include "python/errors.h"

namespace cairn::python {

// The keywords of ingest and map have their defaults in cairn/_building.py.
void BindBuilding(py::module_* module);

}  // namespace cairn::python

#endif  // CAIRN_PYTHON_BUILDING_H_
