// The kinds of index with one knob each that trades time for quality.
#ifndef CAIRN_LAB_EXPERIMENTS_MEASURE_INDEX_VARIANTS_H_
#define CAIRN_LAB_EXPERIMENTS_MEASURE_INDEX_VARIANTS_H_

#include <vector>

#include "lab/experiments/experiment.h"
#include "lab/rivals/index/index_methods.h"

namespace cairn {

const char* IndexLabel(IndexMethod method);  // "random grids", "inverted multi-index", ...

// The defaults of all methods; at the quick size the multi-index has small vocabularies.
IndexMethodOptions DefaultsAt(ExperimentSize size);

// The index of this method with its defaults.
IndexOptions IndexOfMethod(IndexMethod method, ExperimentSize size);

// The same, but for its knob: random grids, descriptors visited a
// cell (as the paper varies it); inverted multi-index, inverted lists and kd-tree, cells visited.
// The exhaustive index has none.
IndexOptions IndexWithEffort(IndexMethod method, ExperimentSize size, int effort);

// The knob's values, ascending.
std::vector<int> Efforts(IndexMethod method, ExperimentSize size);

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_MEASURE_INDEX_VARIANTS_H_
