#include "ingest/maps/run_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <mutex>
#include <numeric>
#include <optional>
#include <set>
#include <string>

#include "core/error.h"
#include "core/parallel_for.h"
#include "core/printable.h"
#include "core/require.h"
#include "ingest/gate_session.h"
#include "ingest/publish_session.h"
#include "ingest/tile_names.h"

namespace cairn {
namespace {

// The task of each tile.
std::vector<int64_t> TaskOfTiles(const SessionPlan& plan, int64_t count) {
  std::vector<size_t> by_work(plan.tiles.size());
  std::iota(by_work.begin(), by_work.end(), size_t{0});
  std::stable_sort(by_work.begin(), by_work.end(),
                   [&](size_t a, size_t b) { return plan.tiles[a].work > plan.tiles[b].work; });
  std::vector<int64_t> task(plan.tiles.size());
  for (size_t rank = 0; rank < by_work.size(); ++rank) {
    const int64_t round = static_cast<int64_t>(rank) / count;
    const int64_t place = static_cast<int64_t>(rank) % count;
    task[by_work[rank]] = round % 2 == 0 ? place : count - 1 - place;
  }
  return task;
}

// What to do about tiles without a result.
std::string Remedy(const PlanFolder& folder, const std::vector<size_t>& tiles, int64_t num_tasks) {
  if (num_tasks <= 0) {
    return fmt::format(
        "run the tasks that failed again, or `cairn build-tiles --plan {} --index 0 "
        "--count 1`, which builds only what is missing",
        folder.path());
  }
  const std::vector<int64_t> task_of_tile = TaskOfTiles(folder.plan(), num_tasks);
  std::set<int64_t> tasks;
  for (const size_t tile_idx : tiles) {
    tasks.insert(task_of_tile[tile_idx]);
  }
  return fmt::format("run `cairn build-tiles --plan {} --count {}` again with --index {}",
                     folder.path(), num_tasks, fmt::join(tasks, ", "));
}

[[noreturn]] void RefuseWithout(const PlanFolder& folder, const std::vector<size_t>& tiles,
                                int64_t num_tasks) {
  std::vector<TileId> tile_ids;
  for (const size_t tile_idx : tiles) {
    tile_ids.push_back(folder.plan().tiles[tile_idx].tile_id);
  }
  throw Error(ErrorCode::kConflict,
              fmt::format("{}: {} of {} tiles have no result: {}; {}", folder.path(), tiles.size(),
                          folder.plan().tiles.size(), TileNames(tile_ids),
                          Remedy(folder, tiles, num_tasks)));
}

void RequireResults(const PlanFolder& folder, int64_t num_tasks) {
  std::vector<size_t> missing;
  for (size_t i = 0; i < folder.plan().tiles.size(); ++i) {
    if (!folder.HasResult(i)) {
      missing.push_back(i);
    }
  }
  if (!missing.empty()) {
    RefuseWithout(folder, missing, num_tasks);
  }
}

void RequireUnpublished(const PlanFolder& folder, const MapStore& store) {
  const SessionPlan& plan = folder.plan();
  const std::optional<SessionRecord> found = store.Snapshot().FindSession(plan.session.name);
  if (found && found->id == plan.session.id &&
      found->content_digest == plan.session.content_digest) {
    folder.RemoveContent();
    throw Error(ErrorCode::kConflict,
                fmt::format("{}: the map has the session '{}' of this plan already; nothing was "
                            "changed",
                            folder.path(), Excerpt(plan.session.name)));
  }
}

}  // namespace

void TaskShare::Validate() const {
  RequireOption(count >= 1, "--count must be at least 1");
  RequireOption(index >= 0 && index < count,
                fmt::format("--index must be between 0 and {}, one less than --count", count - 1));
  RequireOption(num_threads >= 1, "--threads must be at least 1");
}

std::vector<size_t> TilesOfTask(const SessionPlan& plan, int64_t index, int64_t count) {
  const std::vector<int64_t> task_of_tile = TaskOfTiles(plan, count);
  std::vector<size_t> tiles;
  for (size_t i = 0; i < task_of_tile.size(); ++i) {
    if (task_of_tile[i] == index) {
      tiles.push_back(i);
    }
  }
  return tiles;
}

ShareReport BuildShare(PlanFolder* folder, const TaskShare& share, const IngestProgress& progress) {
  share.Validate();
  const std::vector<size_t> tiles = TilesOfTask(folder->plan(), share.index, share.count);
  ShareReport report;
  report.num_tiles = std::ssize(tiles);
  if (tiles.empty()) {
    return report;
  }
  folder->LoadCodebook();
  const SessionTileBuilder builder(folder->plan());
  std::mutex mutex;
  int64_t num_done = 0;
  ParallelFor(static_cast<int>(tiles.size()), share.num_threads, [&](int i) {
    const size_t tile_idx = tiles[static_cast<size_t>(i)];
    const bool has_result = folder->LoadResult(tile_idx).has_value();
    if (!has_result) {
      folder->StoreResult(tile_idx, builder.Build(folder->LoadShard(tile_idx)));
    }
    const std::lock_guard lock(mutex);
    report.num_built += has_result ? 0 : 1;
    ReportProgress(progress, "tiles", ++num_done, report.num_tiles);
  });
  folder->RemoveUnfinished();
  return report;
}

IngestReport PublishPlan(PlanFolder* folder, int64_t num_tasks, MapStore* store,
                         const PublishOptions& options, const IngestProgress& progress) {
  if (!folder->plan().is_unchanged) {
    RequireUnpublished(*folder, *store);
    RequireResults(*folder, num_tasks);
    folder->LoadCodebook();
  }
  const auto load = [&](size_t tile_idx) {
    std::optional<BuiltTile> built = folder->LoadResult(tile_idx);
    if (!built) {
      RefuseWithout(*folder, {tile_idx}, num_tasks);
    }
    return *std::move(built);
  };
  KeyframeAnswers answers;
  if (!options.force) {
    answers = RequireKeyframes(folder->plan(), load, *store, std::make_shared<TileMemory>(),
                               options.num_threads, progress);
  }
  IngestReport report = PublishSession(folder->plan(), load, store, options.patience, progress);
  report.keyframe_answers = answers;
  folder->RemoveContent();
  return report;
}

}  // namespace cairn
