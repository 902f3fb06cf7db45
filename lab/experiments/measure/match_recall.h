// Matching alone: which of a query's keypoints get their own landmark, at what cost.
#ifndef CAIRN_LAB_EXPERIMENTS_MEASURE_MATCH_RECALL_H_
#define CAIRN_LAB_EXPERIMENTS_MEASURE_MATCH_RECALL_H_

#include <cstdint>
#include <string>
#include <vector>

#include "lab/experiments/experiment.h"
#include "lab/experiments/measure/variants.h"

namespace cairn {

// Of one query. A match is right if its landmark, seen from the true pose, stands within a few
// pixels of the keypoint (4 at a focal length of 500, at least 3, plus the landmark's own
// uncertainty); nobody's ids are asked.
struct QueryMatches {
  // Keypoints for which the tiles hold a right landmark with a descriptor within the 0.95 quantile
  // of same-landmark distances: what matching could find.
  int num_matchable = 0;
  int num_found = 0;    // Of them, with a right landmark among their matches.
  int num_matches = 0;  // Keypoint-landmark pairs,
  int num_right = 0;    // and those of them that are right.
  int64_t num_distances = 0;
  double cpu_seconds = 0.0;  // Of MatchFeatures.
};

struct MeasuredMatching {
  Variant variant;
  std::vector<QueryMatches> queries;
  Interval recall;     // Found over matchable, all queries together.
  Interval precision;  // Right over all matches.

  double MeanCpuSeconds() const;
  double MeanDistances() const;
};

// Runs the matching stage of each variant on the world's queries, tiles warm.
std::vector<MeasuredMatching> MeasureMatching(const ExperimentWorld& world,
                                              const std::vector<Variant>& variants,
                                              const ExperimentContext& context);

// Recall of `a` minus recall of `b`, paired.
Interval RecallDifference(const MeasuredMatching& a, const MeasuredMatching& b);

// The variant of the method with most recall; there must be one.
const MeasuredMatching& BestRecallOf(const std::vector<MeasuredMatching>& measured,
                                     const std::string& method);

// A row a variant: method, x, recall, precision, distances a query, CPU time in units of that of
// `reference` and in ms.
ResultTable MatchingTable(const std::string& x_name, const std::vector<MeasuredMatching>& measured,
                          const MeasuredMatching& reference);

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_MEASURE_MATCH_RECALL_H_
