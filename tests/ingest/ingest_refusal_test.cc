// What an ingest refuses leaves the map as it was.
#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "core/error.h"
#include "ingest/ingest_session.h"
#include "support/map_builder.h"
#include "support/street_sessions.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

using testing::ErrorCodeOf;
using testing::SessionNamed;

class IngestRefusal : public ::testing::Test {
 protected:
  // The map must be as it was after any refusal.
  void TearDown() override {
    EXPECT_EQ(store_.Snapshot().Info().num_tiles, 0);
    EXPECT_EQ(store_.Snapshot().Sessions().size(), 0u);
    EXPECT_EQ(store_.Snapshot().CurrentCodebook(), nullptr);
  }

  void Ingest(const testing::StreetWorld& world, const IngestOptions& options) {
    IngestSession(world.Reconstruct(), world.EcefFromWorld(), options, &store_, {});
  }

  testing::TempDir dir_;
  MapStore store_ = MapStore::Create(dir_.File("map.gpkg"));
  const testing::StreetWorld world_{testing::ShortStreet()};
};

TEST_F(IngestRefusal, OfASimilarityThatIsNotFinite) {
  Sim3d broken = world_.EcefFromWorld();
  broken.translation.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(ErrorCodeOf([&] {
              IngestSession(world_.Reconstruct(), broken, SessionNamed("a"), &store_, {});
            }),
            ErrorCode::kBadInput);
}

TEST_F(IngestRefusal, OfAPlaceInTheSky) {
  Sim3d high = world_.EcefFromWorld();
  high.translation *= 1.01;
  EXPECT_EQ(ErrorCodeOf(
                [&] { IngestSession(world_.Reconstruct(), high, SessionNamed("a"), &store_, {}); }),
            ErrorCode::kBadInput);
}

TEST_F(IngestRefusal, OfAReconstructionWithNothingToKeep) {
  IngestOptions options = SessionNamed("a");
  options.max_sigma_m = 1e-6;
  EXPECT_EQ(ErrorCodeOf([&] { Ingest(world_, options); }), ErrorCode::kBadInput);
  EXPECT_EQ(ErrorCodeOf([&] {
              IngestSession(Reconstruction(), world_.EcefFromWorld(), options, &store_, {});
            }),
            ErrorCode::kBadInput);
}

TEST_F(IngestRefusal, OfOptionsThatMakeNoSense) {
  EXPECT_EQ(ErrorCodeOf([&] { Ingest(world_, SessionNamed("")); }), ErrorCode::kInvalidArgument);
  IngestOptions options = SessionNamed("a");
  options.codebook.num_subspaces = 3;
  EXPECT_EQ(ErrorCodeOf([&] { Ingest(world_, options); }), ErrorCode::kInvalidArgument);
}

TEST_F(IngestRefusal, WhileAnotherUpdateRuns) {
  const MapUpdate other = store_.BeginUpdate();
  EXPECT_EQ(ErrorCodeOf([&] { Ingest(world_, SessionNamed("a")); }), ErrorCode::kConflict);
}

TEST_F(IngestRefusal, HalfwayLeavesTheMapAsItWas) {
  const auto fail = [](const char* phase, int64_t done, int64_t total) {
    if (std::string(phase) == "tiles" && done == total) {
      throw Error(ErrorCode::kIo, "full");
    }
  };
  EXPECT_EQ(ErrorCodeOf([&] {
              IngestSession(world_.Reconstruct(), world_.EcefFromWorld(), SessionNamed("a"),
                            &store_, fail);
            }),
            ErrorCode::kIo);
}

}  // namespace
}  // namespace cairn
