// Measures matching alone: the share of a query's keypoints that find their own landmark, and the
// cost.
#ifndef CAIRN_LAB_EXPERIMENTS_MEASURE_MATCH_RECALL_H_
#define CAIRN_LAB_EXPERIMENTS_MEASURE_MATCH_RECALL_H_

#include <cstdint>
#include <string>
#include <vector>

#include "lab/experiments/experiment.h"
#include "lab/experiments/measure/variants.h"

namespace cairn {

// The matches of one query. A match is right if its landmark, projected with the true pose, is
// within a few pixels of the keypoint: 4 pixels at a focal length of 500, at least 3, plus the
// landmark's own uncertainty. Ids are not used.
struct QueryMatches {
  // Keypoints that matching could find: the tiles hold a right landmark with a descriptor within
  // the 0.95 quantile of same-landmark distances.
  int num_matchable = 0;
  int num_found = 0;    // Matchable keypoints with a right landmark among their matches.
  int num_matches = 0;  // Keypoint-landmark pairs.
  int num_right = 0;    // Right ones among num_matches.
  int64_t num_distances = 0;
  double cpu_seconds = 0.0;  // Time of MatchFeatures.
};

struct MeasuredMatching {
  Variant variant;
  std::vector<QueryMatches> queries;
  Interval recall;     // Found / matchable, over all queries together.
  Interval precision;  // Right / all matches.

  double MeanCpuSeconds() const;
  double MeanDistances() const;
};

// Runs the matching stage of each variant on the world's queries. All tiles are in the cache.
std::vector<MeasuredMatching> MeasureMatching(const ExperimentWorld& world,
                                              const std::vector<Variant>& variants,
                                              const ExperimentContext& context);

// Returns the recall of `a` minus the recall of `b`, paired.
Interval RecallDifference(const MeasuredMatching& a, const MeasuredMatching& b);

// Returns the method's variant with the highest recall; there must be one.
const MeasuredMatching& BestRecallOf(const std::vector<MeasuredMatching>& measured,
                                     const std::string& method);

// One row per variant: method, x, recall, precision, distances per query, CPU time relative to
// `reference` and in ms.
ResultTable MatchingTable(const std::string& x_name, const std::vector<MeasuredMatching>& measured,
                          const MeasuredMatching& reference);

}  // namespace cairn

#endif  // CAIRN_LAB_EXPERIMENTS_MEASURE_MATCH_RECALL_H_
