// Queries from outside a map. Every answer to such a query is a false alarm.
#ifndef CAIRN_EVAL_ELSEWHERE_H_
#define CAIRN_EVAL_ELSEWHERE_H_

#include <cstdint>
#include <string>
#include <vector>

#include "core/geodesy.h"
#include "eval/eval_query.h"
#include "eval/evaluation.h"
#include "storage/map/map_store.h"

namespace cairn {

// The positions of a map's keyframes. Throws Error(kInvalidArgument) if the map has none.
std::vector<Geodetic> KeyframePlaces(const MapSnapshot& map);

// Moves each reference pose to one of `places`, chosen by the seed and the query's name. The camera
// keeps its orientation relative to east, north and up. A later AddNoisyPriors then claims that the
// photo was taken at that place. `places` must not be empty.
void PlaceElsewhere(const std::vector<Geodetic>& places, uint64_t seed,
                    std::vector<EvalQuery>* queries);

// Permutes the descriptors of each query among its keypoints, with a permutation drawn from the
// seed and the query's name. Such a query has the descriptors of its photo, but in an arrangement
// that matches no place of the map. The function thus turns a map's own photos into queries from
// elsewhere. The features must have been read.
void PermuteDescriptors(uint64_t seed, std::vector<EvalQuery>* queries);

// The answers of a map to queries from elsewhere.
struct ElsewhereReport {
  int num_queries = 0;
  int num_answered = 0;
  // Answers with a confidence above 0.5 and above 0.9, as counts and as shares of all queries with
  // 95 % Wilson intervals.
  int num_confident = 0;
  int num_sure = 0;
  Interval share_confident;
  Interval share_sure;
  double highest_confidence = 0.0;  // 0 if no query was answered.
};
// Throws Error(kInvalidArgument) if `answers` is empty.
ElsewhereReport MeasureElsewhere(const std::vector<EvalAnswer>& answers);
std::string ElsewhereAsText(const ElsewhereReport& report);

}  // namespace cairn

#endif  // CAIRN_EVAL_ELSEWHERE_H_
