// Puts into words why a query has no pose.
#ifndef CAIRN_ENGINE_EXPLAIN_MISS_H_
#define CAIRN_ENGINE_EXPLAIN_MISS_H_

#include <string>

#include "engine/localizer_options.h"
#include "engine/query/localize_query.h"
#include "engine/query/localize_result.h"
#include "storage/map/map_store.h"

namespace cairn {

// Returns a sentence without final period that says why `result`, which has a reason, has no pose,
// and what its user can do, for example "the nearest tile is 5,400 km away; are latitude and
// longitude swapped?". All words for people come from here: those of the command line, of the page
// and of JSON. `map` is the version that was searched, or null if none was read; only
// kNoCoverage asks it. Without an answer of the map, the sentence is less specific. Does not throw.
std::string ExplainMiss(const LocalizeQuery& query, const LocalizeResult& result,
                        const LocalizerOptions& options, const MapSnapshot* map);

}  // namespace cairn

#endif  // CAIRN_ENGINE_EXPLAIN_MISS_H_
