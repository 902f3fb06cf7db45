// A localizer with a map of several streets, and queries in these streets.
#ifndef CAIRN_TESTS_ENGINE_MAPPED_STREETS_H_
#define CAIRN_TESTS_ENGINE_MAPPED_STREETS_H_

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "core/frames.h"
#include "engine/localizer.h"
#include "ingest/ingest_session.h"
#include "support/reconstruction_builder.h"
#include "support/temp_dir.h"

namespace cairn::testing {

// A map of one or more streets with a localizer.
class MappedStreets {
 public:
  explicit MappedStreets(const std::vector<StreetWorld>& worlds,
                         const LocalizerOptions& options = {})
      : store_(std::make_shared<MapStore>(MapStore::Create(dir_.File("map.gpkg")))),
        localizer_(store_, options, size_t{1} << 28) {
    for (const StreetWorld& world : worlds) {
      Add(world);
    }
  }

  void Add(const StreetWorld& world) {
    IngestOptions options;
    options.session_name = "street " + std::to_string(num_streets_++);
    options.codebook.max_training_descriptors = 5000;
    options.joining = SessionJoining::kApart;  // Equal streets are put at different places.
    IngestSession(world.Reconstruct(), world.EcefFromWorld(), options, store_.get(), {});
  }

  const MapStore& store() const { return *store_; }
  const Localizer& localizer() const { return localizer_; }
  // Returns another localizer on the same map, with its own cache.
  Localizer WithOptions(const LocalizerOptions& options) const {
    return {store_, options, size_t{1} << 28};
  }

 private:
  TempDir dir_;
  std::shared_ptr<MapStore> store_;
  Localizer localizer_;
  int num_streets_ = 0;
};

// A fixture with a map of one street, made once per test suite.
class OneStreetTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    world_ = new StreetWorld();
    map_ = new MappedStreets({*world_});
  }
  static void TearDownTestSuite() {
    delete map_;
    delete world_;
  }
  static const Localizer& localizer() { return map_->localizer(); }

  inline static StreetWorld* world_ = nullptr;
  inline static MappedStreets* map_ = nullptr;
};

// A pose where no keyframe was: lower, off the center line, turned.
inline Rigid3d QueryPose(double x_m) { return StreetWorld::LookAlong({x_m, -1.5, 1.2}, 0.2, 0.03); }

inline LocalizeQuery QueryAt(const StreetWorld& world, const Rigid3d& cam_from_enu) {
  LocalizeQuery query;
  query.camera = world.camera();
  query.features = world.Photograph(cam_from_enu, /*seed=*/99);
  const Rigid3d ecef_from_enu = EcefFromEnu(world.options().origin);
  PositionPrior prior;
  prior.position = GeodeticFromEcef(
      ecef_from_enu * (cam_from_enu.Inverse().translation + Eigen::Vector3d(6.0, -5.0, 3.0)));
  query.prior = prior;
  query.down_in_cam = cam_from_enu.rotation * DownInEnu();
  return query;
}

inline void ExpectPose(const LocalizeResult& result, const StreetWorld& world,
                       const Rigid3d& cam_from_enu, double max_error_m, double max_error_rad) {
  ASSERT_TRUE(result.localized) << NotLocalizedReasonName(result.reason);
  const Rigid3d cam_from_ecef = cam_from_enu * EcefFromEnu(world.options().origin).Inverse();
  EXPECT_LT(
      (result.cam_from_ecef.Inverse().translation - cam_from_ecef.Inverse().translation).norm(),
      max_error_m);
  EXPECT_LT(RotationAngleRad(result.cam_from_ecef.rotation, cam_from_ecef.rotation), max_error_rad);
}

// Expects an answer with the same pose, found in the same way.
inline void ExpectSameAnswer(const LocalizeResult& result, const LocalizeResult& expected) {
  ASSERT_TRUE(result.localized);
  EXPECT_EQ(result.cam_from_anchor.ToMatrix(), expected.cam_from_anchor.ToMatrix());
  EXPECT_EQ(result.covariance, expected.covariance);
  EXPECT_EQ(result.score, expected.score);
  EXPECT_EQ(result.counters.num_distances, expected.counters.num_distances);
  EXPECT_EQ(result.counters.num_matches, expected.counters.num_matches);
  EXPECT_EQ(result.matches.size(), expected.matches.size());
}

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_ENGINE_MAPPED_STREETS_H_
