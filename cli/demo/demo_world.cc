#include "cli/demo/demo_world.h"

#include <fmt/format.h>

#include <map>
#include <utility>

#include "cli/demo/street/street_scene.h"
#include "cli/map_session.h"
#include "core/error.h"
#include "core/features/sift/sift_extractor.h"
#include "core/file_bytes.h"
#include "core/parallel_for.h"
#include "core/radius68.h"
#include "eval/pictures/encode_png.h"

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

constexpr const char* kPhotoPrefix = "map_";
constexpr const char* kPositionsName = "positions.csv";

// Removes the photos of an earlier demo, and no other files.
void RemovePhotos(const fs::path& folder, std::error_code* error) {
  std::vector<fs::path> photos;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, *error)) {
    const fs::path& path = entry.path();
    if (path.filename().string().starts_with(kPhotoPrefix) && path.extension() == ".png") {
      photos.push_back(path);
    }
  }
  for (const fs::path& path : photos) {
    if (!*error) {
      fs::remove(path, *error);
    }
  }
}

void PrepareFolder(const fs::path& output_dir, const std::string& map_path) {
  std::error_code error;
  fs::create_directories(output_dir / "queries", error);
  if (!error) {
    fs::create_directories(output_dir / "photos", error);
  }
  if (!error) {
    RemovePhotos(output_dir / "photos", &error);
  }
  for (const char* suffix : {"", "-wal", "-shm", "-journal"}) {
    if (!error) {
      fs::remove(map_path + suffix, error);
    }
  }
  if (error) {
    throw Error(ErrorCode::kIo, output_dir.string() + ": " + error.message());
  }
}

std::vector<StreetPhoto> TakePhotos(const StreetScene& scene, const std::vector<Rigid3d>& poses,
                                    const std::string& prefix, const char* phase,
                                    Progress* progress) {
  return scene.TakePhotos(poses, prefix, NumCores(),
                          [&](int done, int total) { progress->Update(phase, done, total); });
}

// The photos as files, and their GPS as a table.
void WritePhotos(const std::vector<StreetPhoto>& photos, double gps_sigma_m,
                 const fs::path& output_dir) {
  std::string table = "image,lat_deg,lon_deg,h_m,accuracy_m\n";
  for (const StreetPhoto& photo : photos) {
    WriteFileBytes((output_dir / "photos" / photo.name).string(), EncodePng(photo.image));
    table += fmt::format("{},{:.9f},{:.9f},{:.3f},{:.2f}\n", photo.name, photo.gps->lat_deg(),
                         photo.gps->lon_deg(), photo.gps->h_m, gps_sigma_m * kRadius68PerSigma2d);
  }
  WriteTextFile((output_dir / kPositionsName).string(), table);
}

// As `cairn map` of the files.
MapSessionResult MapStreet(const DemoWorldOptions& options, const std::string& map_path,
                           Progress* progress) {
  MapSessionArguments arguments;
  arguments.session.map_path = map_path;
  IngestOptions& ingest = arguments.session.options.ingest;
  ingest.session_name = "street";
  ingest.codebook.seed = options.seed;
  ingest.num_threads = NumCores();
  // For a third of a megapixel; matching takes quadratic time in them.
  arguments.session.options.mapping.sift.max_features = 1000;
  arguments.input.paths = {(options.output_dir / "photos").string()};
  arguments.input.positions_path = (options.output_dir / kPositionsName).string();
  return MakeMapSession(arguments, [&](const char* phase, int64_t done, int64_t total) {
    progress->Update(phase, done, total);
  });
}

// The motion from the true cameras to those of the map.
PlacementFit MapFromEarth(const StreetScene& scene, const std::vector<StreetPhoto>& photos,
                          const PlacedReconstruction& session) {
  const Rigid3d enu_from_ecef = EcefFromEnu(scene.options().origin).Inverse();
  std::map<std::string, Rigid3d> truth;
  for (const StreetPhoto& photo : photos) {
    truth.emplace(photo.name, photo.cam_from_enu * enu_from_ecef);
  }
  std::vector<PosePair> pairs;
  for (const ReconImage& image : session.reconstruction.images) {
    pairs.push_back({truth.at(image.name),
                     CamFromTarget(image.cam_from_world, session.georegistration.ecef_from_world)});
  }
  return FitPlacement(pairs, PlacementFitOptions());
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
    query.cam_from_ecef =
        CamFromTarget(photo.cam_from_enu * enu_from_ecef, world->map_from_earth.map_from_session);
    WriteFileBytes(query.image_path, EncodePng(photo.image));
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
      TakePhotos(scene, scene.MappingPoses(), kPhotoPrefix, "mapping photos", progress);
  world.gps_sigma_m = scene.options().gps_sigma_m;
  WritePhotos(photos, world.gps_sigma_m, options.output_dir);
  const MapSessionResult result = MapStreet(options, world.map_path, progress);
  world.num_mapping_photos = result.mapped.num_photos;
  world.num_mapped = result.mapped.num_mapped;
  world.ingest = result.report;
  world.map_from_earth = MapFromEarth(scene, photos, result.session);
  MakeQueries(scene, options, progress, &world);
  return world;
}

}  // namespace cairn
