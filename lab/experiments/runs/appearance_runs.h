// Shared code of experiments 2 to 4. The integer program chooses the landmarks; their appearance is
// summarized in different ways. Private to experiments.
#ifndef CAIRN_LAB_EXPERIMENTS_RUNS_APPEARANCE_RUNS_H_
#define CAIRN_LAB_EXPERIMENTS_RUNS_APPEARANCE_RUNS_H_

#include <string>
#include <vector>

#include "ingest/tiles/appearance.h"
#include "lab/experiments/runs/memory_sweep.h"

namespace cairn {

const char* AppearanceLabel(AppearanceKind kind);  // "k-means", "k-medoids", "random".

// Keeps a fixed number of descriptors per landmark, or a ratio of each landmark's descriptors. The
// landmark budget is the same for all variants; the integer program meets it.
IngestVariant FixedCountVariant(const std::string& method, AppearanceKind kind, int count,
                                const ExperimentContext& context);
IngestVariant RatioVariant(const std::string& method, AppearanceKind kind, double ratio,
                           const ExperimentContext& context);

// Measures each kind with each setting, and judges whether k-means beats both other kinds.
ExperimentOutcome CompareKinds(const ExperimentContext& context, const std::string& name,
                               const std::string& title, const std::string& knob_name,
                               const std::vector<double>& knobs,
                               IngestVariant (*make)(const std::string&, AppearanceKind, double,
                                                     const ExperimentContext&));

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_RUNS_APPEARANCE_RUNS_H_
