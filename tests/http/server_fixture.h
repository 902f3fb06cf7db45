// A server on a small synthetic street, which the tests of a suite share.
#ifndef CAIRN_TESTS_HTTP_SERVER_FIXTURE_H_
#define CAIRN_TESTS_HTTP_SERVER_FIXTURE_H_

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "engine/localizer.h"
#include "http/client.h"
#include "http/server.h"
#include "ingest/ingest_session.h"
#include "storage/map/map_store.h"
#include "support/reconstruction_builder.h"
#include "support/temp_dir.h"

namespace cairn::testing {

inline void IngestStreet(const StreetWorld& world, const std::string& session_name,
                         const std::string& map_path) {
  MapStore store = MapStore::Open(map_path, OpenMode::kReadWrite);
  IngestOptions options;
  options.session_name = session_name;
  IngestSession(world.Reconstruct(), world.EcefFromWorld(), options, &store, {});
}

class ServerFixture : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    dir_ = std::make_unique<TempDir>();
    // A small world, because each test is a separate process that makes its own map.
    StreetWorldOptions small;
    small.length_m = 30.0;
    small.num_landmarks = 700;
    world_ = std::make_unique<StreetWorld>(small);
    MapStore::Create(map_path());
    IngestStreet(*world_, "first", map_path());
    server_ = std::make_unique<Server>(Options());
    server_->Start();
  }
  static void TearDownTestSuite() {
    server_.reset();
    world_.reset();
    dir_.reset();
  }

  static std::string map_path() { return dir_->File("street.gpkg"); }
  static ServerOptions Options() {
    ServerOptions options;
    options.map_path = map_path();
    options.port = 0;
    options.default_timeout_ms = 60'000;  // Sanitizers are slow; no test is about time.
    return options;
  }
  static constexpr double kQueryX = 11.0;  // Position of a query along the street, meters.

  static int port() { return server_->port(); }
  static std::string url() { return "http://127.0.0.1:" + std::to_string(port()); }
  static LocalizeClient Client() { return LocalizeClient({.url = url()}); }

  // Returns the pose of the query's camera.
  static Rigid3d TrueCamFromEcef(double x_m) {
    const Rigid3d cam_from_enu = StreetWorld::LookAlong({x_m, 0.3, 1.6}, 0.2);
    return cam_from_enu * EcefFromEnu(world_->options().origin).Inverse();
  }

  // Returns a new view of the street, with gravity and a prior that is 5 m off.
  static LocalizeQuery Query(double x_m = kQueryX) {
    const Rigid3d cam_from_enu = StreetWorld::LookAlong({x_m, 0.3, 1.6}, 0.2);
    const Rigid3d ecef_from_enu = EcefFromEnu(world_->options().origin);
    LocalizeQuery query;
    query.id = "view";
    query.camera = world_->camera();
    query.features = world_->Photograph(cam_from_enu, /*seed=*/99);
    DropKeypointsOutside(&query);
    query.prior.emplace();
    query.prior->position = GeodeticFromEcef(ecef_from_enu * Eigen::Vector3d(x_m + 4.0, 3.0, 1.6));
    query.prior->accuracy_m = 10.0;
    query.down_in_cam = cam_from_enu.rotation * Eigen::Vector3d(0.0, 0.0, -1.0);
    return query;
  }

  // Returns a query with a second camera beside the first, which looks at the left facade.
  static LocalizeQuery RigQuery(double x_m = kQueryX) {
    const Rigid3d cam_from_enu = StreetWorld::LookAlong({x_m, 0.3, 1.6}, 0.2);
    const Rigid3d side_from_enu = StreetWorld::LookAlong({x_m + 0.4, 0.5, 1.8}, 0.7);
    LocalizeQuery side;
    side.camera = world_->camera();
    side.features = world_->Photograph(side_from_enu, /*seed=*/100);
    DropKeypointsOutside(&side);
    LocalizeQuery query = Query(x_m);
    query.other_cameras.push_back(
        {side.camera, side_from_enu * cam_from_enu.Inverse(), side.features});
    return query;
  }

  static std::unique_ptr<TempDir> dir_;
  static std::unique_ptr<StreetWorld> world_;
  static std::unique_ptr<Server> server_;

 private:
  // The builder's pixel noise may move a keypoint over the edge of the image. Detectors never do
  // that.
  static void DropKeypointsOutside(LocalizeQuery* query) {
    FeatureSet& features = query->features;
    int kept = 0;
    for (int i = 0; i < features.size(); ++i) {
      const Keypoint& keypoint = features.keypoints[i];
      if (!query->camera.Contains({keypoint.x_px, keypoint.y_px})) {
        continue;
      }
      features.keypoints[kept] = keypoint;
      features.descriptors.row(kept) = features.descriptors.row(i);
      ++kept;
    }
    features.keypoints.resize(kept);
    features.descriptors.conservativeResize(kept, Eigen::NoChange);
  }
};

inline std::unique_ptr<TempDir> ServerFixture::dir_;
inline std::unique_ptr<StreetWorld> ServerFixture::world_;
inline std::unique_ptr<Server> ServerFixture::server_;

}  // namespace cairn::testing

#endif  // CAIRN_TESTS_HTTP_SERVER_FIXTURE_H_
