// The options of cairn.FusionClient by name, as those of maps are.
#ifndef CAIRN_PYTHON_FUSION_OPTIONS_H_
#define CAIRN_PYTHON_FUSION_OPTIONS_H_

#include "fusion/estimator/fusion_options.h"
#include "python/errors.h"

namespace cairn::python {

// Sets what a dict names; None sets nothing. Throws Error(kInvalidArgument) that names the option.
void SetFusionOptions(py::handle value, fusion::FusionOptions* options);

}  // namespace cairn::python

#endif  // CAIRN_PYTHON_FUSION_OPTIONS_H_
