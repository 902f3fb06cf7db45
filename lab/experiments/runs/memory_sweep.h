// The same city ingested in different ways: accuracy over memory, as experiments 1 to 4 ask.
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
  std::string method;  // A curve of the figure.
  double knob = 0.0;   // Where on it: a budget, a count, a ratio.
  IngestOptions ingest;
};

struct MeasuredIngest {
  IngestVariant variant;
  MapInfo info;
  MeasuredVariant answers;  // Of the paper's best variant of the localizer; x is the knob.

  double MegabytesPerTile() const { return 1e-6 * MeasureMapSizes(info).bytes_per_tile; }
};

// Ingests the world's city once a variant and asks the same queries of each map. Maps are forgotten
// again: they would fill the disk.
std::vector<MeasuredIngest> MeasureIngest(const ExperimentWorldOptions& world,
                                          const std::vector<IngestVariant>& variants,
                                          const ExperimentContext& context);

// The variant of the method at the knob; there must be one.
const MeasuredIngest& At(const std::vector<MeasuredIngest>& measured, const std::string& method,
                         double knob);

// A row a variant: method, knob, megabytes, landmarks and descriptors a tile, average precision,
// recall within 3 m and 10 degrees, CPU time of a query.
ResultTable MemoryTable(const std::string& knob_name, const std::vector<MeasuredIngest>& measured);

// Average precision over megabytes a tile, a curve a method.
Figure MemoryFigure(const std::string& name, const std::string& title,
                    const std::vector<MeasuredIngest>& measured);

// The mean over knobs of the average precision of one method minus that of another, paired.
Interval MeanApDifference(const std::vector<MeasuredIngest>& measured, const std::string& a,
                          const std::string& b, const std::vector<double>& knobs);

// The world that experiments 1 to 4 ingest in many ways.
ExperimentWorldOptions MemoryWorld(const ExperimentContext& context);
ExperimentParameters MemoryParameters(const ExperimentWorldOptions& world,
                                      const std::vector<MeasuredIngest>& measured);

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_RUNS_MEMORY_SWEEP_H_
