// The kinds of index. Each has one setting (its effort) that trades time for quality.
#ifndef CAIRN_LAB_EXPERIMENTS_MEASURE_INDEX_VARIANTS_H_
#define CAIRN_LAB_EXPERIMENTS_MEASURE_INDEX_VARIANTS_H_

#include <vector>

#include "lab/experiments/experiment.h"
#include "lab/rivals/index_methods.h"

namespace cairn {

const char* IndexLabel(IndexMethod method);  // "random grids", "inverted multi-index", ...

// Returns the defaults of all methods. At the quick size, the multi-index has small vocabularies.
IndexMethodOptions DefaultsAt(ExperimentSize size);

// Returns the index of this method with its defaults.
IndexOptions IndexOfMethod(IndexMethod method, ExperimentSize size);

// Returns the same index with another effort. For random grids, the effort is the number of
// descriptors visited per cell (which the paper varies). For the inverted multi-index, inverted
// lists and kd-tree, it is the number of cells visited. The exhaustive index has no such setting.
IndexOptions IndexWithEffort(IndexMethod method, ExperimentSize size, int effort);

// Returns the efforts to measure, ascending.
std::vector<int> Efforts(IndexMethod method, ExperimentSize size);

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_MEASURE_INDEX_VARIANTS_H_
