// Maps and plans of streets, which the tests of plans share.
#ifndef CAIRN_TESTS_INGEST_PLAN_FIXTURE_H_
#define CAIRN_TESTS_INGEST_PLAN_FIXTURE_H_

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "core/error.h"
#include "ingest/ingest_session.h"
#include "ingest/maps/plan_folder.h"
#include "ingest/maps/run_plan.h"
#include "ingest/plan_session.h"
#include "storage/map/map_store.h"
#include "support/map_place.h"
#include "support/reconstruction_builder.h"
#include "support/temp_dir.h"

namespace cairn::testing {

inline StreetWorld Street(uint64_t view_seed, double north_m = 0.0) {
  StreetWorldOptions options;
  options.length_m = 160.0;  // Longer than a tile.
  options.num_landmarks = 1600;
  options.view_seed = view_seed;
  options.origin = Geodetic::FromDegrees(47.3769 + north_m / 111'200.0, 8.5417, 408.0);
  return StreetWorld(options);
}

inline IngestOptions PlanOptionsFor(const std::string& session_name) {
  IngestOptions options;
  options.session_name = session_name;
  options.recorded_at = "2026-01-31T12:00:00Z";
  options.codebook.max_training_descriptors = 1000;
  return options;
}

struct Failure {
  std::optional<ErrorCode> code;
  std::string message;
};

inline Failure FailureOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return {error.code(), error.what()};
  }
  return {};
}

class PlanFixture : public MapPlaceTest {
 protected:
  static IngestReport Ingest(const StreetWorld& world, const IngestOptions& options,
                             MapStore* store) {
    return IngestSession(world.Reconstruct(), world.EcefFromWorld(), options, store, {});
  }

  // Plans into the folder `name` and returns its path.
  std::string Plan(const StreetWorld& world, const IngestOptions& options, const std::string& name,
                   MapStore* store) {
    const std::string path = plans_.File(name);
    PreparePlanFolder(path);
    const Reconstruction reconstruction = world.Reconstruct();
    WritePlan(PlanSession(reconstruction, world.EcefFromWorld(), options, store, {}), store->path(),
              path, {});
    return path;
  }

  static ShareReport Build(const std::string& path, int64_t index = 0, int64_t count = 1) {
    PlanFolder folder(path);
    return BuildShare(&folder, {index, count}, {});
  }

  static IngestReport Publish(const std::string& path, MapStore* store, int64_t num_tasks = 0,
                              bool force = false) {
    PlanFolder folder(path);
    return PublishPlan(&folder, num_tasks, store, {.force = force}, {});
  }

  // A map with one session.
  MapStore MakeMap(const std::string& name) {
    MapStore store = MapStore::Create(Place(name));
    Ingest(Street(1), PlanOptionsFor("first"), &store);
    return store;
  }

  TempDir plans_;
};

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_INGEST_PLAN_FIXTURE_H_
