#include "ingest/maps/recode_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/error.h"
#include "ingest/codebook/load_codebook.h"
#include "ingest/codebook/shipped_codebook.h"
#include "ingest/ingest_session.h"
#include "storage/codebook/codebook_digest.h"
#include "storage/map/map_history.h"
#include "support/map_builder.h"
#include "support/places.h"
#include "support/reconstruction_builder.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

using testing::ExpectError;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class RecodedMap : public ::testing::Test {
 protected:
  RecodedMap() : store_(MapStore::Create(dir_.File("map.gpkg"))) {
    testing::StreetWorldOptions options;
    options.length_m = 45.0;
    options.num_landmarks = 800;
    const testing::StreetWorld world(options);
    IngestOptions ingest;
    ingest.session_name = "first";
    ingest.codebook.source = CodebookSource::kTrained;
    IngestSession(world.Reconstruct(), world.EcefFromWorld(), ingest, &store_, {});
  }

  std::string CurrentDigest() const {
    const MapSnapshot snapshot = store_.Snapshot();
    return snapshot.CodebookDigest(snapshot.CurrentCodebook()->id);
  }

  testing::TempDir dir_;
  MapStore store_;
};

TEST_F(RecodedMap, IsANewVersionInTheOtherCodebook) {
  const MapTotals before = store_.Snapshot().Info();
  const RecodeReport report = RecodeMap(*ShippedCodebook(), &store_, {});
  EXPECT_EQ(report.map_version, store_.Snapshot().version());
  EXPECT_EQ(report.num_descriptors, before.num_descriptors);
  EXPECT_EQ(store_.Snapshot().Info().num_landmarks, before.num_landmarks);
  EXPECT_EQ(CurrentDigest(), DigestOf(*ShippedCodebook()));
  EXPECT_EQ(store_.Snapshot().Versions(1)[0].kind, "recode");
  EXPECT_THAT(store_.Check({}).problems, IsEmpty());
}

TEST_F(RecodedMap, GoesBackByRollback) {
  const std::string digest = CurrentDigest();
  const MapVersion before = store_.Snapshot().version();
  RecodeMap(*ShippedCodebook(), &store_, {});
  const MapVersion after = RollBack(before, &store_);
  EXPECT_EQ(CurrentDigest(), digest);
  EXPECT_THAT(store_.Snapshot().Diff(before, after), IsEmpty());
  EXPECT_THAT(store_.Check({}).problems, IsEmpty());
}

TEST_F(RecodedMap, IsNotCodedTwice) {
  RecodeMap(*ShippedCodebook(), &store_, {});
  const MapVersion version = store_.Snapshot().version();
  ExpectError([&] { RecodeMap(*ShippedCodebook(), &store_, {}); }, ErrorCode::kConflict,
              "is coded with codebook " + DigestOf(*ShippedCodebook()) + " already");
  EXPECT_EQ(store_.Snapshot().version(), version);
}

TEST_F(RecodedMap, KeepsItsKindOfDescriptors) {
  Codebook other = *ShippedCodebook();
  other.descriptor_type = "superpoint";
  ExpectError([&] { RecodeMap(other, &store_, {}); }, ErrorCode::kBadInput, "'superpoint'");
}

TEST_F(RecodedMap, IsNotTouchedWhileAnotherUpdateRuns) {
  const MapUpdate other = store_.BeginUpdate();
  ExpectError([&] { RecodeMap(*ShippedCodebook(), &store_, {}); }, ErrorCode::kConflict, "");
}

TEST_F(RecodedMap, WhenEmptyGetsTheCodebookForItsFirstSession) {
  MapStore empty = MapStore::Create(dir_.File("empty.gpkg"));
  ExpectError([&] { LoadCodebook(empty.path()); }, ErrorCode::kBadInput, "has no codebook");
  EXPECT_EQ(RecodeMap(*LoadCodebook(store_.path()), &empty, {}).num_tiles, 0);
  EXPECT_EQ(DigestOf(*LoadCodebook(empty.path())), CurrentDigest());
}

TEST(LoadCodebook, ReadsFilesMapsAndTheShippedOne) {
  const testing::TempDir dir;
  const std::string path = dir.File("a.codebook");
  const Codebook codebook = testing::RandomCodebook();
  const std::vector<uint8_t> bytes = EncodeCodebook(codebook);
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), std::ssize(bytes));
  EXPECT_EQ(DigestOf(*LoadCodebook(path)), DigestOf(codebook));
  EXPECT_EQ(DigestOf(*LoadCodebook("shipped")), DigestOf(*ShippedCodebook()));
  std::filesystem::resize_file(path, bytes.size() - 4);
  ExpectError([&] { LoadCodebook(path); }, ErrorCode::kMapDamaged, "a.codebook");
  ExpectError([&] { LoadCodebook(dir.File("none")); }, ErrorCode::kNotFound, "none");
  std::ofstream(dir.File("text")) << "a text";
  ExpectError([&] { LoadCodebook(dir.File("text")); }, ErrorCode::kBadInput, "text");
}

}  // namespace
}  // namespace cairn
