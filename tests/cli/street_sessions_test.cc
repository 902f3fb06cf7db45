// Tests two sessions of the rendered street: size of the map, and queries before and after.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "cli/demo/street/reconstruct_known_poses.h"
#include "cli/demo/street/street_scene.h"
#include "eval/eval_query.h"
#include "ingest/ingest_session.h"
#include "support/recognized.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

constexpr double kMaxBytesOfBoth = 1.25;  // Over those of one session.
constexpr size_t kPhotosOfStop = 3;

// A short street, mapped at twice the usual density: half of its photos are as dense as usual.
class StreetSessions : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    StreetOptions options;
    options.length_m = 40.0;
    options.mapping_step_m = 2.25;
    options.num_queries = 12;
    scene_ = new StreetScene(options);
    photos_ = new std::vector<StreetPhoto>(scene_->TakePhotos(scene_->MappingPoses(), "map_"));
    queries_ = new std::vector<EvalQuery>(TakeQueries());
  }
  static void TearDownTestSuite() {
    delete queries_;
    delete photos_;
    delete scene_;
  }

  static std::vector<EvalQuery> TakeQueries() {
    const Rigid3d enu_from_ecef = EcefFromEnu(scene_->options().origin).Inverse();
    std::vector<EvalQuery> queries;
    for (const StreetPhoto& photo : scene_->TakePhotos(scene_->QueryPoses(), "query_")) {
      EvalQuery query;
      query.name = photo.name;
      query.query.id = photo.name;
      query.query.camera = scene_->camera();
      query.query.features = ExtractSift(photo.image);
      query.cam_from_ecef = photo.cam_from_enu * enu_from_ecef;
      queries.push_back(std::move(query));
    }
    AddNoisyPriors({}, &queries);
    return queries;
  }

  // Every `step`-th stop of photos [begin, end), from the stop `first` on.
  static std::vector<StreetPhoto> Stops(size_t begin, size_t end, size_t first, size_t step) {
    std::vector<StreetPhoto> stops;
    for (size_t i = begin; i < end; ++i) {
      if ((i - begin) / kPhotosOfStop % step == first) {
        stops.push_back((*photos_)[i]);
      }
    }
    return stops;
  }

  static IngestReport Ingest(const std::vector<StreetPhoto>& photos, const std::string& name,
                             MapStore* store) {
    const Rigid3d ecef_from_enu = EcefFromEnu(scene_->options().origin);
    IngestOptions options;
    options.session_name = name;
    return IngestSession(ReconstructWithKnownPoses(scene_->camera(), photos),
                         {1.0, ecef_from_enu.rotation, ecef_from_enu.translation}, options, store,
                         {});
  }

  static int64_t BytesOf(const MapStore& store) { return store.Snapshot().Info().payload_bytes; }

  // Ingests the second session into the map of the first. Returns the bytes after it. No query may
  // be lost.
  static int64_t Join(const std::vector<StreetPhoto>& second, MapStore* store) {
    const int64_t one = BytesOf(*store);
    const std::vector<bool> before = testing::Recognized(*queries_, *store);
    const IngestReport report = Ingest(second, "second", store);
    const std::vector<bool> after = testing::Recognized(*queries_, *store);
    int num_before = 0, num_after = 0;
    for (size_t i = 0; i < queries_->size(); ++i) {
      EXPECT_LE(before[i], after[i]) << (*queries_)[i].name;
      num_before += before[i] ? 1 : 0;
      num_after += after[i] ? 1 : 0;
    }
    std::printf(
        "%lld bytes, with the second session %lld; %lld merged, %lld new; %d of %zu "
        "queries before, %d after\n",
        static_cast<long long>(one), static_cast<long long>(BytesOf(*store)),
        static_cast<long long>(report.changes.num_merged),
        static_cast<long long>(report.changes.num_new), num_before, queries_->size(), num_after);
    EXPECT_GT(num_after, static_cast<int>(queries_->size()) / 2);
    return BytesOf(*store);
  }

  static const StreetScene* scene_;
  static const std::vector<StreetPhoto>* photos_;
  static const std::vector<EvalQuery>* queries_;
};
const StreetScene* StreetSessions::scene_ = nullptr;
const std::vector<StreetPhoto>* StreetSessions::photos_ = nullptr;
const std::vector<EvalQuery>* StreetSessions::queries_ = nullptr;

TEST_F(StreetSessions, AlternatingStopsHaveTheSizeOfOne) {
  const testing::TempDir dir;
  MapStore store = MapStore::Create(dir.File("halves.gpkg"));
  Ingest(Stops(0, photos_->size(), 0, 2), "first", &store);
  const int64_t one = BytesOf(store);
  const int64_t both = Join(Stops(0, photos_->size(), 1, 2), &store);
  EXPECT_LE(static_cast<double>(both), kMaxBytesOfBoth * static_cast<double>(one));
}

// The photos of one pass look where no photo of the other looks, so each pass adds its own share.
TEST_F(StreetSessions, TwoPassesHaveTheSizeOfOneSessionOfBoth) {
  const testing::TempDir dir;
  MapStore one = MapStore::Create(dir.File("one.gpkg"));
  Ingest(Stops(0, photos_->size(), 0, 2), "both passes", &one);
  MapStore two = MapStore::Create(dir.File("two.gpkg"));
  Ingest(Stops(0, photos_->size() / 2, 0, 2), "first", &two);
  const int64_t both = Join(Stops(photos_->size() / 2, photos_->size(), 0, 2), &two);
  std::printf("both passes as one session: %lld bytes\n", static_cast<long long>(BytesOf(one)));
  EXPECT_LE(static_cast<double>(both), kMaxBytesOfBoth * static_cast<double>(BytesOf(one)));
}

}  // namespace
}  // namespace cairn
