#include "lab/city/city_world.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/error.h"
#include "core/geodesy.h"
#include "core/parallel_for.h"
#include "core/radius68.h"
#include "core/require.h"
#include "core/tile_id.h"
#include "lab/city/city.h"
#include "lab/city/simulated_mapping.h"
#include "storage/map/map_store.h"

namespace cairn {
namespace {

constexpr int kMinLandmarksOfTile = 100;
constexpr std::array<const char*, 3> kSizeNames = {"quick", "medium", "paper"};

// The mapped landmarks around each query.
class MappedAroundQueries {
 public:
  explicit MappedAroundQueries(const PhoneQueries& queries)
      : queries_(queries), mapped_(queries.size()) {}

  void Add(const MappedChunk& chunk, double max_range_m) {
    const double reach_m = max_range_m + kMarginM;
    CityBox box;
    for (const ReconLandmark& landmark : chunk.reconstruction.landmarks) {
      box.extend(Eigen::Vector2d(landmark.x_in_world.head<2>()));
    }
    for (size_t i = 0; i < mapped_.size(); ++i) {
      const Eigen::Vector2d at =
          queries_.Place(static_cast<int>(i)).cam_from_site.Inverse().translation.head<2>();
      if (box.exteriorDistance(at) > reach_m) {
        continue;
      }
      for (size_t k = 0; k < chunk.city_landmarks.size(); ++k) {
        const Eigen::Vector3d& x_in_world = chunk.reconstruction.landmarks[k].x_in_world;
        if ((x_in_world.head<2>() - at).squaredNorm() < reach_m * reach_m) {
          mapped_[i].insert(chunk.city_landmarks[k]);
        }
      }
    }
  }

  const std::unordered_set<uint64_t>& Around(int query_idx) const {
    return mapped_[static_cast<size_t>(query_idx)];
  }

 private:
  static constexpr double kMarginM = 5.0;  // Noise moves landmarks by less than this.

  const PhoneQueries& queries_;
  std::vector<std::unordered_set<uint64_t>> mapped_;
};

// Returns the center of a tile near `place` that no zone border cuts.
Geodetic MiddleOfWholeTile(const Geodetic& place) {
  constexpr double kAwayFromBorderM = 300.0;
  const Eigen::Vector3d x_in_ecef =
      EcefFromEnu(place) * Eigen::Vector3d(-kAwayFromBorderM, 0.0, 0.0);
  Geodetic middle = TileId::Containing(GeodeticFromEcef(x_in_ecef)).Anchor();
  middle.h_m = place.h_m;
  return middle;
}

void Ingest(const CityWorldOptions& options, const SimulatedMapping& mapping,
            const MappedChunk& chunk, MapStore* store) {
  IngestOptions ingest = options.ingest;
  ingest.session_name = "tile " + chunk.tile_id.ToString();
  ingest.source = "simulated city";
  if (ingest.earth_accuracy_m == 0.0) {
    ingest.earth_accuracy_m = kRadius68PerSigma3d * options.mapping.noise.deformation_m;
  }
  // Neighboring tiles share no landmarks: there is nothing to join.
  ingest.joining = SessionJoining::kApart;
  ingest.gate.max_lost_share = 1.0;
  IngestSession(chunk.reconstruction, mapping.EcefFromWorld(), ingest, store, {});
}

std::vector<EvalQuery> Build(const CityWorldOptions& options, const City& city,
                             const DescriptorModel& model, const PhoneQueries& queries,
                             const std::string& map_path,
                             const std::function<void(int done, int total)>& progress) {
  const SimulatedMapping mapping(city, model, options.mapping);
  MappedAroundQueries mapped(queries);
  MapStore store = MapStore::Create(map_path);
  const std::vector<TileId> tiles = mapping.Tiles();
  const auto num_tiles = static_cast<int>(tiles.size());
  for (int i = 0; i < num_tiles; ++i) {
    const MappedChunk chunk = mapping.MapTile(tiles[static_cast<size_t>(i)], options.num_threads);
    // At the city's edge a tile may have only a handful of landmarks, which are of no use in a map.
    if (chunk.city_landmarks.size() >= kMinLandmarksOfTile) {
      mapped.Add(chunk, options.queries.detector.max_range_m);
      Ingest(options, mapping, chunk, &store);
    }
    if (progress) {
      progress(i + 1, num_tiles);
    }
  }
  std::vector<EvalQuery> made(static_cast<size_t>(queries.size()));
  ParallelFor(queries.size(), options.num_threads,
              [&](int i) { made[static_cast<size_t>(i)] = queries.Make(i, mapped.Around(i)); });
  return made;
}

}  // namespace

void CityWorldOptions::Validate() const {
  city.Validate();
  mapping.Validate();
  queries.Validate();
  descriptors.Validate();
  IngestOptions named = ingest;
  named.session_name = "tile";
  named.Validate();
  RequireWithin("num_threads", num_threads, 1, 256);
}

const char* CityWorldSizeName(CityWorldSize size) { return kSizeNames[static_cast<size_t>(size)]; }

CityWorldSize CityWorldSizeFromName(const std::string& name) {
  const auto found = std::find(kSizeNames.begin(), kSizeNames.end(), name);
  if (found == kSizeNames.end()) {
    throw Error(ErrorCode::kInvalidArgument,
                "size '" + name + "' is unknown; sizes are quick, medium, paper");
  }
  return static_cast<CityWorldSize>(found - kSizeNames.begin());
}

CityWorldOptions CityWorldPreset(CityCharacter character, CityWorldSize size) {
  CityWorldOptions options;
  options.city = CityPreset(character);
  switch (size) {
    case CityWorldSize::kQuick:
      options.city.area_km2 = 0.01;
      options.city.min_landmark_size_m = 0.05;
      options.mapping.num_passes = 2;
      options.mapping.keyframe_spacing_m = 6.0;
      options.mapping.rig.image_width_px = options.mapping.rig.image_height_px = 560;
      options.mapping.rig.focal_px = 300.0;
      options.mapping.detector.max_keypoints = 250;
      options.queries.num_queries = 20;
      break;
    case CityWorldSize::kMedium:
      options.city.area_km2 = 0.09;
      options.queries.num_queries = 200;
      break;
    case CityWorldSize::kPaper:
      options.city.center = MiddleOfWholeTile(options.city.center);
      options.city.area_km2 = 0.0225;
      options.city.min_landmark_size_m = 0.01;
      options.mapping.num_passes = 6;
      options.mapping.keyframe_spacing_m = 3.0;
      options.mapping.rig.image_width_px = options.mapping.rig.image_height_px = 1200;
      options.mapping.rig.focal_px = 630.0;
      options.mapping.detector.max_keypoints = 2000;
      options.queries.num_queries = 300;
      break;
  }
  return options;
}

std::vector<EvalQuery> BuildCityWorld(const CityWorldOptions& options, const std::string& map_path,
                                      const std::function<void(int done, int total)>& progress) {
  options.Validate();
  const City city(options.city);
  const DescriptorModel model(options.descriptors);
  return Build(options, city, model, PhoneQueries(city, model, options.queries), map_path,
               progress);
}

std::vector<EvalQuery> BuildCityWorld(const CityWorldOptions& options,
                                      const std::vector<PhonePlace>& places,
                                      const std::string& map_path,
                                      const std::function<void(int done, int total)>& progress) {
  options.Validate();
  const City city(options.city);
  const DescriptorModel model(options.descriptors);
  return Build(options, city, model, PhoneQueries(city, model, options.queries, places), map_path,
               progress);
}

}  // namespace cairn
