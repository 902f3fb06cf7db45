// The kinds of index with one knob each that trades time for quality.
#ifndef CAIRN_EVAL_EXPERIMENTS_INDEX_VARIANTS_H_
#define CAIRN_EVAL_EXPERIMENTS_INDEX_VARIANTS_H_

#include <vector>

#include "engine/matching/index_options.h"
#include "eval/experiments/experiment.h"

namespace cairn {

const char* IndexLabel(IndexKind kind);  // "random grids", "inverted multi-index", ...

// The engine's default index of this kind; at the quick size the multi-index has small
// vocabularies.
IndexOptions IndexOfKind(IndexKind kind, ExperimentSize size);

// The same, but for its knob: random grids, descriptors visited a
// cell (as the paper varies it); inverted multi-index, inverted lists and kd-tree, cells visited.
// The exhaustive index has none.
IndexOptions IndexWithEffort(IndexKind kind, ExperimentSize size, int effort);

// The knob's values, ascending.
std::vector<int> Efforts(IndexKind kind, ExperimentSize size);

}  // namespace cairn

#endif  // CAIRN_EVAL_EXPERIMENTS_INDEX_VARIANTS_H_
