// What experiments 2 to 4 share: landmarks chosen by the integer program, their appearance
// summarized in different ways; private to experiments.
#ifndef CAIRN_LAB_EXPERIMENTS_RUNS_APPEARANCE_RUNS_H_
#define CAIRN_LAB_EXPERIMENTS_RUNS_APPEARANCE_RUNS_H_

#include <string>
#include <vector>

#include "ingest/summarize/appearance.h"
#include "lab/experiments/runs/memory_sweep.h"

namespace cairn {

const char* AppearanceLabel(AppearanceKind kind);  // "k-means", "k-medoids", "random".

// A fixed number of descriptors a landmark, or a ratio of those it has. The landmark budget is the
// same for all and met by the integer program.
IngestVariant FixedCountVariant(const std::string& method, AppearanceKind kind, int count,
                                const ExperimentContext& context);
IngestVariant RatioVariant(const std::string& method, AppearanceKind kind, double ratio,
                           const ExperimentContext& context);

// Measures each kind at each knob and asks whether k-means beats both others.
ExperimentOutcome CompareKinds(const ExperimentContext& context, const std::string& name,
                               const std::string& title, const std::string& knob_name,
                               const std::vector<double>& knobs,
                               IngestVariant (*make)(const std::string&, AppearanceKind, double,
                                                     const ExperimentContext&));

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_RUNS_APPEARANCE_RUNS_H_
