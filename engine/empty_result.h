// Answers without a pose whose stages have not run.
#ifndef CAIRN_ENGINE_EMPTY_RESULT_H_
#define CAIRN_ENGINE_EMPTY_RESULT_H_

#include "engine/localizer_options.h"
#include "engine/query/localize_query.h"
#include "engine/query/localize_result.h"
#include "storage/map/map_store.h"

namespace cairn {

// The result with which a query begins. `snapshot` is the version that is read, or null if the
// tiles are not those of a map on disk.
LocalizeResult EmptyResult(const LocalizeQuery& query, const MapSnapshot* snapshot);

// The answer to a query whose time ended before its stages began: kTimeout.
LocalizeResult LateResult(const LocalizeQuery& query, const LocalizerOptions& options,
                          const MapSnapshot& snapshot);

}  // namespace cairn

#endif  // CAIRN_ENGINE_EMPTY_RESULT_H_
