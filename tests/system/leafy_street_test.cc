// Tests photos of a street whose trees have grown leaves since the mapping.
#include <gtest/gtest.h>

#include <memory>

#include "cli/demo/street/reconstruct_known_poses.h"
#include "cli/demo/street/street_scene.h"
#include "core/features/sift/sift_extractor.h"
#include "engine/localizer.h"
#include "eval/evaluation.h"
#include "ingest/ingest_session.h"
#include "storage/map/map_store.h"
#include "support/temp_dir.h"

namespace cairn::testing {
namespace {

StreetOptions MappedStreet() {
  StreetOptions options;
  options.length_m = 45.0;
  options.num_queries = 8;
  return options;
}

// As a phone sees it, whose photos have more features than are kept.
StreetOptions PhotographedStreet(int num_trees) {
  StreetOptions options = MappedStreet();
  options.num_trees = num_trees;
  options.image_width_px *= 2;
  options.image_height_px *= 2;
  options.focal_px *= 2.0;
  return options;
}

void MapStreet(const StreetScene& scene, const std::string& map_path) {
  const std::vector<StreetPhoto> photos = scene.TakePhotos(scene.MappingPoses(), "map_");
  const Rigid3d ecef_from_enu = EcefFromEnu(scene.options().origin);
  MapStore store = MapStore::Create(map_path);
  IngestOptions options;
  options.session_name = "winter";
  IngestSession(ReconstructWithKnownPoses(scene.camera(), photos),
                {1.0, ecef_from_enu.rotation, ecef_from_enu.translation}, options, &store, {});
}

// Photos of the scene from the poses, as queries with noisy prior and gravity.
std::vector<EvalQuery> Queries(const StreetScene& scene, const std::vector<Rigid3d>& poses) {
  const Rigid3d enu_from_ecef = EcefFromEnu(scene.options().origin).Inverse();
  std::vector<EvalQuery> queries;
  for (const StreetPhoto& photo : scene.TakePhotos(poses, "query_")) {
    EvalQuery query;
    query.name = photo.name;
    query.query.camera = scene.camera();
    query.query.features = ExtractSift(photo.image);
    query.cam_from_ecef = photo.cam_from_enu * enu_from_ecef;
    queries.push_back(query);
  }
  AddNoisyPriors({}, &queries);
  return queries;
}

int NumRight(const std::string& map_path, const std::vector<EvalQuery>& queries) {
  const Localizer localizer = Localizer::Open(map_path, {}, size_t{1} << 28);
  const EvalReport report = Evaluate(
      queries, [&](const EvalQuery& query) { return localizer.Localize(query.query); }, {});
  int num_right = 0;
  for (const EvalAnswer& answer : report.answers) {
    num_right += IsWithin(answer, kCorrect);
  }
  return num_right;
}

TEST(LeafyStreet, IsRecognizedBehindItsTrees) {
  const TempDir dir;
  const std::string map_path = dir.File("street.gpkg");
  const StreetScene mapped(MappedStreet()), bare(PhotographedStreet(0)),
      leafy(PhotographedStreet(6));
  MapStreet(mapped, map_path);
  const std::vector<Rigid3d> poses = mapped.QueryPoses();
  EXPECT_EQ(NumRight(map_path, Queries(bare, poses)), 8);
  EXPECT_EQ(NumRight(map_path, Queries(leafy, poses)), 8);
}

}  // namespace
}  // namespace cairn::testing
