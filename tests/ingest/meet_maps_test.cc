// Tests how maps of one place become one map.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "core/error.h"
#include "ingest/codebook/load_codebook.h"
#include "ingest/ingest_session.h"
#include "ingest/maps/merge_maps.h"
#include "ingest/maps/recode_map.h"
#include "ingest/place/keyframe_features.h"
#include "storage/tile/tile_codec.h"
#include "support/reconstruction_builder.h"
#include "support/temp_dir.h"
#include "support/tile_builder.h"

namespace cairn {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Two maps of one street, made on two visits, in the codebook of the first.
class MeetingMaps : public ::testing::Test {
 protected:
  MeetingMaps()
      : a_(MapStore::Create(dir_.File("a.gpkg"))), b_(MapStore::Create(dir_.File("b.gpkg"))) {
    Ingest(2, "monday", Eigen::Vector3d::Zero(), &a_);
  }

  static Reconstruction Visit(uint64_t view_seed, Sim3d* ecef_from_world) {
    testing::StreetWorldOptions options;
    options.length_m = 45.0;
    options.num_landmarks = 800;
    options.view_seed = view_seed;
    const testing::StreetWorld world(options);
    *ecef_from_world = world.EcefFromWorld();
    return world.Reconstruct();
  }

  static void Ingest(uint64_t view_seed, const std::string& name, const Eigen::Vector3d& shift_m,
                     MapStore* store) {
    Sim3d ecef_from_world;
    const Reconstruction visit = Visit(view_seed, &ecef_from_world);
    ecef_from_world.translation += shift_m;
    IngestOptions options;
    options.session_name = name;
    options.codebook.source = CodebookSource::kTrained;
    IngestSession(visit, ecef_from_world, options, store, {});
  }

  void MakeB(const Eigen::Vector3d& shift_m) {
    RecodeMap(*LoadCodebook(a_.path()), &b_, {});
    Ingest(3, "tuesday", shift_m, &b_);
  }

  MergeReport Merge(const MapMergeOptions& options = {}) {
    return MergeMaps(a_, b_, dir_.File("c.gpkg"), options, {});
  }

  static int64_t BytesOf(const MapStore& store) { return store.Snapshot().Info().payload_bytes; }

  testing::TempDir dir_;
  MapStore a_;
  MapStore b_;
};

TEST_F(MeetingMaps, ShareTheLandmarksThatBothKnow) {
  MakeB(Eigen::Vector3d::Zero());
  const MergeReport report = Merge();
  EXPECT_GT(report.comparison.num_expected, 10);
  EXPECT_EQ(report.comparison.num_localized, report.comparison.num_expected);
  EXPECT_GT(report.changes.num_merged, b_.Snapshot().Info().num_landmarks / 2);
  EXPECT_LT(BytesOf(MapStore::Open(dir_.File("c.gpkg"), OpenMode::kReadOnly)),
            3 * (BytesOf(a_) + BytesOf(b_)) / 4);
  EXPECT_THAT(MapStore::Open(dir_.File("c.gpkg"), OpenMode::kReadOnly).Check({}).problems,
              IsEmpty());
}

TEST(KeyframeFeatures, LeaveOutALandmarkWithoutDescriptors) {
  testing::RandomTileOptions options;
  options.num_keyframes = 1;
  options.num_landmarks_per_keyframe = options.num_landmarks;
  Tile tile = testing::RandomTile(options);
  tile.keyframes[0].cam_from_tile = Rigid3d();  // Looks up.
  for (Eigen::Vector3f& x_in_tile : tile.x_in_tile) {
    x_in_tile = {0.0f, 0.0f, 10.0f};
  }
  const Camera camera(CameraModel::kPinhole, 640, 480, {500.0, 500.0, 320.0, 240.0});
  const auto seen = [&] {
    const DescriptorMatrix descriptors =
        DescriptorMatrix::Zero(static_cast<Eigen::Index>(tile.num_descriptors()), 16);
    return FeaturesOfKeyframe(tile, 0, camera, descriptors).landmarks;
  };
  const auto last = static_cast<uint32_t>(tile.num_landmarks() - 1);
  EXPECT_THAT(seen(), ::testing::Contains(last));
  const uint32_t begin = tile.descriptor_begin[last];
  tile.descriptor_begin[last + 1] = begin;
  for (auto* codes : {&tile.azimuth_codes, &tile.orientation_codes, &tile.size_codes}) {
    codes->resize(begin);
  }
  tile.codes.resize(size_t{begin} * static_cast<size_t>(tile.code_size));
  EXPECT_THAT(seen(), ::testing::Not(::testing::Contains(last)));
}

TEST_F(MeetingMaps, StandWhereTheFirstOneSeesTheSecond) {
  MakeB(Eigen::Vector3d(0.6, -0.5, 0.3));
  const MergeReport report = Merge();
  EXPECT_NEAR(report.comparison.fit.moved_m, Eigen::Vector3d(0.6, -0.5, 0.3).norm(), 0.05);
  EXPECT_GT(report.changes.num_merged, b_.Snapshot().Info().num_landmarks / 2);
  const MapStore merged = MapStore::Open(dir_.File("c.gpkg"), OpenMode::kReadOnly);
  EXPECT_THAT(merged.Check({}).problems, IsEmpty());
  const std::vector<KeyframeRecord> monday =
      merged.Snapshot().KeyframesOfSession(merged.Snapshot().FindSession("monday")->id);
  const std::vector<KeyframeRecord> tuesday =
      merged.Snapshot().KeyframesOfSession(merged.Snapshot().FindSession("tuesday")->id);
  ASSERT_EQ(monday.size(), tuesday.size());  // Both visits took their photos at the same places.
  for (const KeyframeRecord& keyframe : tuesday) {
    const auto same_place = std::find_if(
        monday.begin(), monday.end(),
        [&](const KeyframeRecord& other) { return other.image_name == keyframe.image_name; });
    ASSERT_NE(same_place, monday.end());
    EXPECT_EQ(keyframe.tile_id,
              TileId::Containing(GeodeticFromEcef(keyframe.cam_from_ecef.Inverse().translation)));
    EXPECT_LT((same_place->cam_from_ecef.Inverse().translation -
               keyframe.cam_from_ecef.Inverse().translation)
                  .norm(),
              0.1);
  }
}

TEST_F(MeetingMaps, AreRefusedIfTheyContradictEachOther) {
  MakeB(Eigen::Vector3d(3.0, 2.0, 2.0));
  try {
    Merge();
    FAIL() << "was merged";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kConflict);
    EXPECT_THAT(error.what(), HasSubstr("b.gpkg contradicts the map"));
    EXPECT_THAT(error.what(), HasSubstr("--apart"));
  }
  MapMergeOptions apart;
  apart.joining = SessionJoining::kApart;
  EXPECT_EQ(Merge(apart).totals.num_landmarks,
            a_.Snapshot().Info().num_landmarks + b_.Snapshot().Info().num_landmarks);
}

TEST_F(MeetingMaps, AreRefusedHoweverFarTheyAreMisplaced) {
  MakeB(Eigen::Vector3d(20.0, 15.0, -10.0));
  try {
    Merge();
    FAIL() << "was merged";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kConflict);
    EXPECT_THAT(error.what(), HasSubstr("of its photos 26.9"));
  }
}

TEST_F(MeetingMaps, CountWhatTheyLoseIfTheyAreKeptApart) {
  MakeB(Eigen::Vector3d(8.0, 4.0, 5.0));
  MapMergeOptions apart;
  apart.joining = SessionJoining::kApart;
  const KeyframeAnswers answers = Merge(apart).keyframe_answers;
  EXPECT_GT(answers.num_asked, 20);
  EXPECT_GT(answers.num_lost, answers.num_asked / 5);
}

TEST_F(MeetingMaps, KeepTheirBudget) {
  MakeB(Eigen::Vector3d::Zero());
  MapMergeOptions options;
  options.selection.max_descriptors = 300;
  const MergeReport report = Merge(options);
  EXPECT_GT(report.changes.num_evicted, 0);
  const MapSnapshot merged = MapStore::Open(dir_.File("c.gpkg"), OpenMode::kReadOnly).Snapshot();
  for (const TileRecord& tile : merged.AllTiles(100)) {
    EXPECT_LE(tile.num_descriptors, 300);
  }
}

TEST_F(MeetingMaps, OfTwoCodebooksAreRecodedOnDemand) {
  Ingest(3, "tuesday", Eigen::Vector3d::Zero(), &b_);
  try {
    Merge();
    FAIL() << "was merged";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("cairn recode "));
  }
  MapMergeOptions options;
  options.recode = true;
  EXPECT_GT(Merge(options).changes.num_merged, 100);
  EXPECT_THAT(MapStore::Open(dir_.File("c.gpkg"), OpenMode::kReadOnly).Check({}).problems,
              IsEmpty());
}

TEST_F(MeetingMaps, AreRefusedIfTheSecondStandsFarFromWhereTheFirstSeesIt) {
  MakeB(Eigen::Vector3d(300.0, 300.0, 300.0));
  EXPECT_THAT([&] { Merge(); }, ::testing::ThrowsMessage<Error>(
                                    ::testing::ContainsRegex("sees [0-9]+ of its photos 519\\.")));
}

}  // namespace
}  // namespace cairn
