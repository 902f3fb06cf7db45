#include "cli/demo/demo_world.h"

#include <fstream>
#include <utility>

#include "cli/demo/street/street_scene.h"
#include "core/error.h"
#include "core/parallel_for.h"
#include "core/scene/reconstruct_known_poses.h"
#include "eval/pictures/encode_png.h"
#include "storage/map/map_store.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

StreetOptions MakeStreetOptions(const DemoWorldOptions& options) {
  StreetOptions street;
  street.seed = options.seed;
  if (options.quick) {
    street.length_m = 60.0;
    street.num_queries = 6;
  }
  return street;
}

void PrepareFolder(const fs::path& output_dir, const std::string& map_path) {
  std::error_code error;
  fs::create_directories(output_dir / "queries", error);
  for (const char* suffix : {"", "-wal", "-shm", "-journal"}) {
    if (!error) {
      fs::remove(map_path + suffix, error);
    }
  }
  if (error) {
    throw Error(ErrorCode::kIo, output_dir.string() + ": " + error.message());
  }
}

void WriteFile(const std::string& path, const std::vector<uint8_t>& bytes) {
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  if (!file.flush()) {
    throw Error(ErrorCode::kIo, path + ": cannot write");
  }
}

// The world of the reconstruction is east-north-up at the scene's origin, in meters.
Sim3d EcefFromWorld(const Geodetic& origin) {
  const Rigid3d ecef_from_enu = EcefFromEnu(origin);
  return {1.0, ecef_from_enu.rotation, ecef_from_enu.translation};
}

std::vector<StreetPhoto> TakePhotos(const StreetScene& scene, const std::vector<Rigid3d>& poses,
                                    const std::string& prefix, const char* phase,
                                    Progress* progress) {
  return scene.TakePhotos(poses, prefix, NumCores(),
                          [&](int done, int total) { progress->Update(phase, done, total); });
}

IngestReport IngestPhotos(const StreetScene& scene, const std::vector<StreetPhoto>& photos,
                          const std::string& map_path, uint64_t seed, Progress* progress) {
  const auto show = [&](const char* phase, int64_t done, int64_t total) {
    progress->Update(phase, done, total);
  };
  KnownPoseOptions known_poses;
  known_poses.num_threads = NumCores();
  const Reconstruction reconstruction =
      ReconstructWithKnownPoses(scene.camera(), photos, known_poses, show);
  MapStore store = MapStore::Create(map_path);
  IngestOptions options;
  options.session_name = "street";
  options.source = "cairn demo";
  options.codebook.seed = seed;
  options.num_threads = NumCores();
  return IngestSession(reconstruction, EcefFromWorld(scene.options().origin), options, &store,
                       show);
}

void MakeQueries(const StreetScene& scene, const DemoWorldOptions& options, Progress* progress,
                 DemoWorld* world) {
  std::vector<StreetPhoto> photos =
      TakePhotos(scene, scene.QueryPoses(), "query_", "query photos", progress);
  const Rigid3d enu_from_ecef = EcefFromEnu(scene.options().origin).Inverse();
  for (StreetPhoto& photo : photos) {
    EvalQuery query;
    query.name = photo.name;
    query.image_path = (options.output_dir / "queries" / photo.name).string();
    query.query.id = photo.name;
    query.query.camera = scene.camera();
    query.cam_from_ecef = photo.cam_from_enu * enu_from_ecef;
    WriteFile(query.image_path, EncodePng(photo.image));
    world->queries.push_back(std::move(query));
    world->photos.push_back(std::move(photo.image));
  }
  ParallelFor(static_cast<int>(world->queries.size()), NumCores(),
              [&](int i) { world->queries[i].query.features = ExtractSift(world->photos[i]); });
  PriorNoiseOptions noise;
  noise.seed = options.seed;
  AddNoisyPriors(noise, &world->queries);
}

}  // namespace

DemoWorld MakeDemoWorld(const DemoWorldOptions& options, Progress* progress) {
  DemoWorld world;
  world.map_path = (options.output_dir / "street.gpkg").string();
  PrepareFolder(options.output_dir, world.map_path);
  const StreetScene scene(MakeStreetOptions(options));
  const std::vector<StreetPhoto> photos =
      TakePhotos(scene, scene.MappingPoses(), "map_", "mapping photos", progress);
  world.num_mapping_photos = static_cast<int>(photos.size());
  world.ingest = IngestPhotos(scene, photos, world.map_path, options.seed, progress);
  MakeQueries(scene, options, progress, &world);
  return world;
}

}  // namespace cairn
