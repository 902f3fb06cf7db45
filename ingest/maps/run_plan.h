// The steps of an ingest that is spread over processes: `cairn build-tiles` and `cairn publish`.
// `cairn plan` is PlanSession and WritePlan.
#ifndef CAIRN_INGEST_MAPS_RUN_PLAN_H_
#define CAIRN_INGEST_MAPS_RUN_PLAN_H_

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "ingest/ingest_report.h"
#include "ingest/maps/plan_folder.h"
#include "storage/map/map_store.h"

namespace cairn {

// One of `count` tasks.
struct TaskShare {
  int64_t index = 0;  // From 0.
  int64_t count = 1;
  int num_threads = 1;

  // Throws Error(kInvalidArgument) unless 0 <= index < count.
  void Validate() const;
};

// The tiles of a task, as ascending indices into plan.tiles; every tile is in one task. The tiles
// with the most work are assigned first, in alternating order, so that all tasks take about equally
// long.
std::vector<size_t> TilesOfTask(const SessionPlan& plan, int64_t index, int64_t count);

struct ShareReport {
  int64_t num_tiles = 0;
  int64_t num_built = 0;  // The others had a result already.
};

// Builds the tiles of a task that have no sound result yet, without a look at the map. May be
// repeated, may run in several processes at a time, and may be killed at any moment. Reports
// "tiles". Throws Error(kBadInput) if a shard is damaged. Tiles that are already built stay.
ShareReport BuildShare(PlanFolder* folder, const TaskShare& share, const IngestProgress& progress);

struct PublishOptions {
  std::chrono::milliseconds patience{0};  // While another update of the map runs.
  int num_threads = 1;                    // That ask keyframes of the map.
  bool force = false;                     // Publish whatever these keyframes lose.
};

// Publishes the plan and removes its shards and results from the folder. `num_tasks`, if positive,
// is the `count` of the tasks that built it, for messages. Throws Error(kConflict), which names the
// tiles and what to do, if tiles have no sound result, and as PublishSession. A plan that was
// published already is refused with Error(kConflict), and its shards and results are removed.
// Before, unless forced, asks keyframes of the map what they lose; see RequireKeyframes. A refused
// plan keeps its shards and results.
IngestReport PublishPlan(PlanFolder* folder, int64_t num_tasks, MapStore* store,
                         const PublishOptions& options, const IngestProgress& progress);

}  // namespace cairn

#endif  // CAIRN_INGEST_MAPS_RUN_PLAN_H_
