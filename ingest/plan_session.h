// The first step of an ingest: decides what the session changes, and changes nothing.
#ifndef CAIRN_INGEST_PLAN_SESSION_H_
#define CAIRN_INGEST_PLAN_SESSION_H_

#include <memory>
#include <vector>

#include "core/rigid3.h"
#include "core/scene/reconstruction.h"
#include "ingest/place/known_tiles.h"
#include "ingest/session_plan.h"
#include "ingest/tiles/placed_session.h"
#include "ingest/tiles/tile_shard.h"
#include "storage/map/map_store.h"

namespace cairn {

// A plan with what its tiles are made of. `reconstruction` and the store must outlive it.
struct PlannedSession {
  SessionPlan plan;
  const Reconstruction* reconstruction = nullptr;
  PlacedSession session;                 // Where the map sees it; landmarks of equal id are joined.
  std::vector<LandmarkId> landmark_ids;  // Parallel to the landmarks.
  std::shared_ptr<const MapSnapshot> base;  // Always set.
  // `base` without the replaced session. Set unless the plan changes nothing.
  std::shared_ptr<const KnownTiles> known;

  // Returns what plan.tiles[tile_idx] is built from. Reads the map. Safe to call from any thread.
  // Throws Error(kUnavailable) if the base version was pruned since, Error(kMapDamaged) if the
  // map's payload is missing.
  TileShard Shard(size_t tile_idx) const;
};

// Places the session on Earth, asks the map where it stands, moves it there, links landmarks that
// the map knows, and numbers everything that is new. Locks the map only while it reserves the ids
// (MapStore::ReserveIds). A plan that never becomes a version leaves gaps in the ids and nothing
// else.
//
// Throws what IngestSession throws.
PlannedSession PlanSession(const Reconstruction& reconstruction, const Sim3d& ecef_from_world,
                           const IngestOptions& options, MapStore* store,
                           const IngestProgress& progress);

}  // namespace cairn

#endif  // CAIRN_INGEST_PLAN_SESSION_H_
