// Ingests the same city in different ways and measures accuracy over memory, for experiments 1 to
// 4.
#ifndef CAIRN_LAB_EXPERIMENTS_RUNS_MEMORY_SWEEP_H_
#define CAIRN_LAB_EXPERIMENTS_RUNS_MEMORY_SWEEP_H_

#include <string>
#include <vector>

#include "ingest/ingest_session.h"
#include "lab/experiments/experiment.h"
#include "lab/experiments/measure/evaluation_size.h"
#include "lab/experiments/measure/variants.h"

namespace cairn {

struct IngestVariant {
  std::string method;  // The figure's curve.
  double knob = 0.0;   // Position on the curve: a budget, a count, a ratio.
  IngestOptions ingest;
};

struct MeasuredIngest {
  IngestVariant variant;
  MapInfo info;
  // Answers of the paper's best variant of the localizer; x is the knob.
  MeasuredVariant answers;

  double MegabytesPerTile() const { return 1e-6 * MeasureMapSizes(info).bytes_per_tile; }
};

// Ingests the world's city once per variant and runs the same queries on each map. Removes the maps
// again to free disk space.
std::vector<MeasuredIngest> MeasureIngest(const ExperimentWorldOptions& world,
                                          const std::vector<IngestVariant>& variants,
                                          const ExperimentContext& context);

// Returns the method's variant at the knob; there must be one.
const MeasuredIngest& At(const std::vector<MeasuredIngest>& measured, const std::string& method,
                         double knob);

// One row per variant: method, knob, megabytes, landmarks and descriptors per tile, average
// precision, recall within 3 m and 10 degrees, CPU time per query.
ResultTable MemoryTable(const std::string& knob_name, const std::vector<MeasuredIngest>& measured);

// Average precision over megabytes per tile, one curve per method.
Figure MemoryFigure(const std::string& name, const std::string& title,
                    const std::vector<MeasuredIngest>& measured);

// Returns the mean over the knobs of the average precision of `a` minus that of `b`, paired.
Interval MeanApDifference(const std::vector<MeasuredIngest>& measured, const std::string& a,
                          const std::string& b, const std::vector<double>& knobs);

// Returns the world that experiments 1 to 4 ingest in many ways.
ExperimentWorldOptions MemoryWorld(const ExperimentContext& context);
ExperimentParameters MemoryParameters(const ExperimentWorldOptions& world,
                                      const std::vector<MeasuredIngest>& measured);

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_RUNS_MEMORY_SWEEP_H_
