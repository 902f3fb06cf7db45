// Sessions that hold photos which the map has already.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/error.h"
#include "ingest/ingest_session.h"
#include "ingest/session_digest.h"
#include "support/map_builder.h"
#include "support/street_sessions.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

using ::testing::HasSubstr;
using testing::SessionNamed;
using testing::ShortStreet;

// The photos from `begin` to `end` under other names, in a reconstruction of their own.
Reconstruction PhotosOf(const testing::StreetWorld& world, int begin, int end) {
  Reconstruction part = world.Reconstruct();
  part.images.assign(part.images.begin() + begin, part.images.begin() + end);
  std::vector<ReconLandmark> landmarks;
  for (ReconLandmark& landmark : part.landmarks) {
    std::erase_if(landmark.observations, [&](const ReconObservation& seen) {
      return seen.image_idx < begin || seen.image_idx >= end;
    });
    for (ReconObservation& seen : landmark.observations) {
      seen.image_idx -= begin;
    }
    if (landmark.observations.size() >= 2) {
      landmarks.push_back(landmark);
    }
  }
  part.landmarks = landmarks;
  for (ReconImage& image : part.images) {
    image.name = "copy of " + image.name;
  }
  return part;
}

class SharedPhotosTest : public ::testing::Test {
 protected:
  SharedPhotosTest() : store_(MapStore::Create(dir_.File("map.gpkg"))) {}

  void Ingest(const Reconstruction& reconstruction, const IngestOptions& options) {
    IngestSession(reconstruction, world_.EcefFromWorld(), options, &store_, {});
  }

  std::string RefusalOf(const Reconstruction& reconstruction, const IngestOptions& options) {
    const MapVersion version = store_.Snapshot().version();
    try {
      Ingest(reconstruction, options);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kConflict);
      EXPECT_EQ(store_.Snapshot().version(), version);
      return error.what();
    }
    return "no error";
  }

  testing::TempDir dir_;
  MapStore store_;
  testing::StreetWorld world_{ShortStreet()};
};

TEST_F(SharedPhotosTest, UnderOtherNamesAreRefused) {
  Ingest(PhotosOf(world_, 0, 16), SessionNamed("monday"));
  const std::string message = RefusalOf(PhotosOf(world_, 4, 16), SessionNamed("tuesday"));
  EXPECT_THAT(message, HasSubstr("12 of the 12 photos"));
  EXPECT_THAT(message, HasSubstr("'monday'"));
}

TEST_F(SharedPhotosTest, OfOverlappingListsAreRefused) {
  Ingest(PhotosOf(world_, 0, 10), SessionNamed("monday"));
  EXPECT_THAT(RefusalOf(PhotosOf(world_, 6, 16), SessionNamed("tuesday")),
              HasSubstr("4 of the 10 photos"));
}

TEST_F(SharedPhotosTest, AreTakenInIfTheyAreFewOrBelongThereTwiceOrReplaceTheSession) {
  Ingest(PhotosOf(world_, 0, 9), SessionNamed("monday"));
  EXPECT_EQ(RefusalOf(PhotosOf(world_, 8, 16), SessionNamed("tuesday")), "no error");
  IngestOptions apart = SessionNamed("twice");
  apart.joining = SessionJoining::kApart;
  EXPECT_EQ(RefusalOf(PhotosOf(world_, 0, 9), apart), "no error");
}

TEST_F(SharedPhotosTest, MayReplaceTheirSession) {
  Ingest(PhotosOf(world_, 0, 10), SessionNamed("monday"));
  EXPECT_EQ(RefusalOf(PhotosOf(world_, 2, 12), SessionNamed("monday")), "no error");
}

TEST_F(SharedPhotosTest, OfAnotherVisitAreNone) {
  Ingest(PhotosOf(world_, 0, 16), SessionNamed("monday"));
  testing::StreetWorldOptions street = ShortStreet();
  street.view_seed = 3;
  EXPECT_EQ(RefusalOf(testing::StreetWorld(street).Reconstruct(), SessionNamed("tuesday")),
            "no error");
}

TEST_F(SharedPhotosTest, DigestsOfOlderMapsHaveNone) {
  SessionRecord old_session, session;
  session.content_digest = std::string(48, '1') + "0000000a0000000b";
  old_session.content_digest = std::string(48, '1');
  EXPECT_TRUE(AreOneIngest(session.content_digest, old_session.content_digest));
  EXPECT_EQ(CountSharedPhotos(session, old_session).num_compared, 0);
  EXPECT_EQ(CountSharedPhotos(session, session).num_shared, 2);
}

// Without --recorded, a session that the map has was recorded when the map says.
TEST_F(SharedPhotosTest, KeepTheTimeOfTheirSession) {
  IngestOptions options = SessionNamed("monday");
  options.recorded_at = "2024-05-01T10:00:00Z";
  Ingest(world_.Reconstruct(), options);
  const MapVersion version = store_.Snapshot().version();
  Ingest(world_.Reconstruct(), SessionNamed("monday"));
  EXPECT_EQ(store_.Snapshot().version(), version);
  Reconstruction changed = world_.Reconstruct();
  changed.landmarks.resize(changed.landmarks.size() - 1);
  Ingest(changed, SessionNamed("monday"));
  EXPECT_GT(store_.Snapshot().version(), version);
  EXPECT_EQ(store_.Snapshot().FindSession("monday")->recorded_at, options.recorded_at);
  for (ReconImage& image : changed.images) {
    image.name = "another " + image.name;
  }
  Ingest(changed, SessionNamed("monday"));
  EXPECT_NE(store_.Snapshot().FindSession("monday")->recorded_at, options.recorded_at);
}

}  // namespace
}  // namespace cairn
