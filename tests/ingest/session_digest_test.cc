#include "ingest/session_digest.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "core/error.h"
#include "ingest/ingest_option_visit.h"
#include "ingest/ingest_session.h"
#include "storage/map/map_store.h"
#include "support/street_sessions.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

Sim3d SomePlacement() {
  Sim3d placement;
  placement.scale = 2.0;
  placement.translation = {1.0, 2.0, 3.0};
  return placement;
}

// No option has its default.
IngestOptions OtherOptions() {
  IngestOptions options;
  options.recorded_at = "2026-01-31T12:00:00Z";
  options.joining = SessionJoining::kApart;
  options.selection = {LandmarkSelectionKind::kCoverage, 1000, 3, 200, 50, 7.5, 9};
  options.appearance = {AppearanceKind::kRandom, 3, 0.5, 2, 8, 77};
  options.upkeep.linking = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9};
  options.upkeep.merging = {0.11, 0.12, 0.13};
  options.upkeep.viewpoints = {1.5, 0.25};
  options.upkeep.persistence = {0.2, 0.4};
  options.upkeep.enough_landmarks = 99;
  options.upkeep.least_existence = 0.05;
  options.max_sigma_m = 1.25;
  options.max_reprojection_error_px = 3.5;
  options.fitting = SessionFitting::kAdjust;
  return options;
}

// Other digests would make new sessions of all that the maps of today have.
TEST(DigestOfOptions, IsThatOfEarlierPrograms) {
  IngestOptions defaults;
  defaults.recorded_at = "2026-01-31T12:00:00Z";
  EXPECT_EQ(DigestOf(SomePlacement(), defaults), "b62859f8a444c68f");
  EXPECT_EQ(DigestOf(SomePlacement(), OtherOptions()), "df8746b91a88666d");
}

// The digest does not know the size, and the principal point is where it was.
TEST(IngestSession, ACorrectedImageSizeIsAnotherSession) {
  const testing::TempDir dir;
  MapStore store = MapStore::Create(dir.File("map.gpkg"));
  const testing::StreetWorld world(testing::ShortStreet());
  Reconstruction reconstruction = world.Reconstruct();
  IngestOptions options = testing::SessionNamed("monday");
  options.now = "2026-01-01T00:00:00Z";
  const auto ingest = [&] {
    return IngestSession(reconstruction, world.EcefFromWorld(), options, &store, {});
  };
  EXPECT_FALSE(ingest().is_unchanged);
  EXPECT_TRUE(ingest().is_unchanged);
  const Camera& camera = reconstruction.cameras[0];
  reconstruction.cameras[0] =
      Camera(camera.model(), camera.width_px() + 8, camera.height_px(), camera.params());
  options.now = "2026-02-01T00:00:00Z";
  EXPECT_FALSE(ingest().is_unchanged);
  EXPECT_TRUE(ingest().is_unchanged);
  EXPECT_EQ(store.Snapshot().FindSession("monday")->recorded_at, "2026-01-01T00:00:00Z");
}

// Counts the options of a struct, or changes one of them.
class OptionCounter {
 public:
  OptionCounter(int changed, int* count) : changed_(changed), count_(*count) {}

  template <typename T>
  void Visit(std::string_view, T& value, const OptionRange&, std::string_view) const {
    if (count_++ == changed_) {
      value = static_cast<T>(static_cast<int>(value) + 1);
    }
  }
  template <typename Options>
  void Section(std::string_view, Options& options, std::string_view) const {
    VisitOptions(options, *this);
  }

 private:
  int changed_;
  int& count_;
};

TEST(DigestOfOptions, ChangesWithEachOptionOfATile) {
  TileOptions defaults;
  int count = 0;
  VisitOptions(defaults, OptionCounter(-1, &count));
  EXPECT_GT(count, 30);
  std::set<std::string> digests = {DigestOf(SomePlacement(), IngestOptions())};
  for (int i = 0; i < count; ++i) {
    IngestOptions options;
    TileOptions& tile_options = options;
    int visited = 0;
    VisitOptions(tile_options, OptionCounter(i, &visited));
    digests.insert(DigestOf(SomePlacement(), options));
  }
  EXPECT_EQ(digests.size(), static_cast<size_t>(count) + 1);
}

std::string RefusalOf(const std::function<void(IngestOptions*)>& change) {
  IngestOptions options;
  options.session_name = "monday";
  options.Validate();
  change(&options);
  try {
    options.Validate();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
    return error.what();
  }
  return "";
}

TEST(IngestOptions, ARefusalNamesTheOptionAsTheOptionsFileDoes) {
  EXPECT_THAT(RefusalOf([](auto* options) { options->upkeep.linking.max_ratio = 1.5; }),
              AllOf(HasSubstr("ingest.upkeep.linking.max_ratio = 1.5"), HasSubstr("(0, 1]")));
  EXPECT_THAT(RefusalOf([](auto* options) { options->upkeep.merging.least_sigma_m = 0.0; }),
              HasSubstr("ingest.upkeep.merging.least_sigma_m = 0 must be above 0"));
  EXPECT_THAT(RefusalOf([](auto* options) { options->selection.min_observations = 1; }),
              HasSubstr("ingest.selection.min_observations = 1 must be at least 2"));
  EXPECT_THAT(RefusalOf([](auto* options) { options->codebook.num_subspaces = 65; }),
              HasSubstr("ingest.codebook.num_subspaces = 65 must be in [1, 64]"));
  EXPECT_THAT(RefusalOf([](auto* options) { options->gate.max_lost_share = -0.1; }),
              HasSubstr("ingest.gate.max_lost_share"));
}

TEST(IngestOptions, RefuseNumbersThatAreNone) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_NE(RefusalOf([=](auto* options) { options->agreement.max_moved_m = nan; }), "");
  EXPECT_EQ(RefusalOf([=](auto* options) { options->agreement.max_moved_m = infinity; }), "");
  EXPECT_NE(RefusalOf([=](auto* options) { options->agreement.position_accuracy_m = infinity; }),
            "");
  EXPECT_NE(RefusalOf([=](auto* options) { options->upkeep.persistence.loss_per_year = 1.0; }), "");
}

}  // namespace
}  // namespace cairn
