#include "street_map.h"

#include <filesystem>
#include <vector>

#include "cli/demo/street/reconstruct_known_poses.h"
#include "core/parallel_for.h"
#include "ingest/ingest_session.h"
#include "storage/map/map_store.h"

namespace cairn {

void MakeStreetMap(const StreetScene& scene, const std::string& map_path) {
  const int num_threads = NumCores();
  const std::vector<StreetPhoto> photos =
      scene.TakePhotos(scene.MappingPoses(), "map_", num_threads);
  KnownPoseOptions known_poses;
  known_poses.num_threads = num_threads;
  const Reconstruction reconstruction =
      ReconstructWithKnownPoses(scene.camera(), photos, known_poses);
  for (const char* suffix : {"", "-wal", "-shm", "-journal"}) {
    std::filesystem::remove(map_path + suffix);
  }
  MapStore store = MapStore::Create(map_path);
  IngestOptions options;
  options.session_name = "street";
  options.source = "track_and_localize";
  // The reconstruction's world frame is east-north-up at the origin of the scene, in meters.
  const Rigid3d ecef_from_enu = EcefFromEnu(scene.options().origin);
  IngestSession(reconstruction, {1.0, ecef_from_enu.rotation, ecef_from_enu.translation}, options,
                &store, {});
}

}  // namespace cairn
