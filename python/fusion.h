// cairn.FusionClient: inertial samples, tracked features and answers of the map become poses.
#ifndef CAIRN_PYTHON_FUSION_H_
#define CAIRN_PYTHON_FUSION_H_

#include "python/errors.h"

namespace cairn::python {

void BindFusion(py::module_* module);

}  // namespace cairn::python

#endif  // CAIRN_PYTHON_FUSION_H_
