// Queries that show nothing of a map: every answer to them is one too many.
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

// Where a map's photos were taken. Throws Error(kInvalidArgument) if it has none.
std::vector<Geodetic> KeyframePlaces(const MapSnapshot& map);

// Moves each reference pose to one of `places`, drawn by the seed and the query's name; the camera
// keeps its orientation against east, north and up. AddNoisyPriors then tells the map that the
// photo was taken there. `places` must not be empty.
void PlaceElsewhere(const std::vector<Geodetic>& places, uint64_t seed,
                    std::vector<EvalQuery>* queries);

// Deals the descriptors of each query out anew among its keypoints, drawn by the seed and the
// query's name. Such a query has the descriptors of its photo, but nowhere do they form what a map
// knows. Makes queries from elsewhere of a map's own photos. The features must have been read.
void PermuteDescriptors(uint64_t seed, std::vector<EvalQuery>* queries);

// What a map said to queries that show nothing of it.
struct ElsewhereReport {
  int num_queries = 0;
  int num_answered = 0;
  // Answers with a confidence above 0.5 and above 0.9: shares of all queries with their 95 % Wilson
  // intervals.
  int num_confident = 0;
  int num_sure = 0;
  Interval share_confident;
  Interval share_sure;
  double highest_confidence = 0.0;  // 0 without an answer.
};
// Throws Error(kInvalidArgument) without answers.
ElsewhereReport MeasureElsewhere(const std::vector<EvalAnswer>& answers);
std::string ElsewhereAsText(const ElsewhereReport& report);

}  // namespace cairn

#endif  // CAIRN_EVAL_ELSEWHERE_H_
