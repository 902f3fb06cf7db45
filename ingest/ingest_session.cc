#include "ingest/ingest_session.h"

#include <mutex>
#include <utility>
#include <vector>

#include "core/parallel_for.h"
#include "ingest/gate_session.h"
#include "ingest/plan_session.h"
#include "ingest/publish_session.h"
#include "ingest/session_tile_builder.h"

namespace cairn {
namespace {

// Builds the tiles of a plan, and keeps what the gate may ask for in the memory of the plan.
std::vector<BuiltTile> BuildTiles(const PlannedSession& planned, int num_threads,
                                  const IngestProgress& progress) {
  const SessionTileBuilder builder(planned.plan);
  const auto num_tiles = static_cast<int>(planned.plan.tiles.size());
  std::vector<BuiltTile> tiles(planned.plan.tiles.size());
  std::mutex mutex;
  int64_t num_done = 0;
  const auto report = [&](int64_t num_more) {
    const std::lock_guard lock(mutex);
    num_done += num_more;
    ReportProgress(progress, "tiles", num_done, num_tiles);
  };
  report(0);
  ParallelFor(num_tiles, num_threads, [&](int i) {
    tiles[i] = builder.Build(planned.Shard(static_cast<size_t>(i)));
    EncodedTile& encoded = tiles[i].tile.encoded;
    const auto decoded = std::exchange(encoded.decoded, nullptr);
    if (decoded != nullptr && AsksKeyframes(planned.plan)) {
      planned.known->memory()->Keep(encoded.payload, decoded);
    }
    report(1);
  });
  return tiles;
}

std::vector<LandmarkId> IdsInReconstruction(const PlannedSession& planned) {
  std::vector<LandmarkId> ids(planned.reconstruction->landmarks.size(), LandmarkId{});
  for (size_t i = 0; i < planned.landmark_ids.size(); ++i) {
    ids[planned.session.landmarks[i].recon_idx] = planned.landmark_ids[i];
  }
  return ids;
}

}  // namespace

IngestReport IngestSession(const Reconstruction& reconstruction, const Sim3d& ecef_from_world,
                           const IngestOptions& options, MapStore* store,
                           const IngestProgress& progress, const BeforePublish& before_publish) {
  const PlannedSession planned =
      PlanSession(reconstruction, ecef_from_world, options, store, progress);
  std::vector<BuiltTile> tiles;
  KeyframeAnswers answers;
  if (!planned.plan.is_unchanged) {
    tiles = BuildTiles(planned, options.num_threads, progress);
    answers = RequireKeyframes(
        planned.plan, [&](size_t i) { return tiles[i]; }, *store, planned.known->memory(),
        options.num_threads, progress);
  }
  if (before_publish) {
    before_publish(planned);
  }
  IngestReport report = PublishSession(
      planned.plan, [&](size_t i) { return std::move(tiles[i]); }, store, options.patience,
      progress);
  report.keyframe_answers = answers;
  if (!report.is_unchanged) {
    report.landmark_ids = IdsInReconstruction(planned);
  }
  return report;
}

}  // namespace cairn
