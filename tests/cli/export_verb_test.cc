// Tests `cairn export`: what is written is what the map has; and the frames of `cairn ingest`.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "cli/batch/world_frame.h"
#include "cli/exports/export_points.h"
#include "cli/run_cairn.h"
#include "ingest/colmap/colmap_model.h"
#include "ingest/colmap/write_colmap.h"
#include "ingest/ingest_session.h"
#include "storage/map/map_store.h"
#include "storage/tile/tile_codec.h"
#include "support/reconstruction_builder.h"
#include "support/temp_dir.h"

namespace cairn::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

std::string TextOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

// A map of one or two visits of a street over two tiles; made once.
class ExportVerb : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    dir_ = new TempDir();
    // In another process, because tests run `cairn` by fork.
    ASSERT_EQ(RunInChild([] { MakeMap(); }), 0);
  }
  static void TearDownTestSuite() {
    delete dir_;
    dir_ = nullptr;
  }
  static void MakeMap() {
    MapStore store = MapStore::Create(MapPath());
    for (const char* name : {"monday", "tuesday"}) {
      StreetWorldOptions options;
      options.length_m = 200.0;
      options.keyframe_step_m = 5.0;
      options.view_seed = std::strlen(name);
      const StreetWorld world(options);
      IngestOptions ingest;
      ingest.session_name = name;
      IngestSession(world.Reconstruct(), world.EcefFromWorld(), ingest, &store, {});
    }
  }

  static std::string MapPath() { return dir_->File("street.gpkg"); }
  static std::string File(const std::string& name) { return dir_->File(name); }
  static Geodetic Origin() { return StreetWorldOptions().origin; }
  static Finished Export(const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"export", MapPath()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunCairn(arguments);
  }
  static std::string OriginText() {
    return fmt::format("{:.10f},{:.10f},{}", Origin().lat_deg(), Origin().lon_deg(), Origin().h_m);
  }

  static TempDir* dir_;
};
TempDir* ExportVerb::dir_ = nullptr;

TEST_F(ExportVerb, AModelHasTheKeyframesAndTheLandmarksThatTheySee) {
  const Finished finished = Export(
      {"--colmap", File("model"), "--origin", OriginText(), "--json", "--session", "monday"});
  ASSERT_EQ(finished.exit_code, 0) << finished.err;
  const auto summary = nlohmann::json::parse(finished.out);
  const ColmapModel model = ReadColmapModel(File("model"));
  const StreetWorld world({.length_m = 200.0, .keyframe_step_m = 5.0});
  ASSERT_EQ(model.images.size(), world.KeyframePoses().size());
  EXPECT_EQ(summary["images"], model.images.size());
  EXPECT_EQ(model.cameras.size(), 1u);
  std::map<std::string, const ColmapImage*> image_of_name;
  std::map<uint32_t, const ColmapImage*> image_of_id;
  for (const ColmapImage& image : model.images) {
    image_of_name[image.name] = &image;
    image_of_id[image.image_id] = &image;
  }
  for (size_t i = 0; i < world.KeyframePoses().size(); ++i) {
    const auto image = image_of_name.find(fmt::format("{:04}.jpg", i));
    ASSERT_NE(image, image_of_name.end());
    // The ingest may move a session by what it knows better; the first one stays.
    const Eigen::Vector3d x_in_enu = image->second->cam_from_world.Inverse().translation;
    EXPECT_LT((x_in_enu - world.KeyframePoses()[i].Inverse().translation).norm(), 1e-5);
  }
  EXPECT_GT(model.points.size(), 200u);
  size_t num_observations = 0;
  for (const ColmapPoint& point : model.points) {
    for (const auto& [image_id, keypoint_idx] : point.track) {
      const ColmapImage& image = *image_of_id.at(image_id);
      const Camera& camera = model.cameras.at(image.camera_id);
      const auto pixel = camera.Project(image.cam_from_world * point.x_in_world);
      ASSERT_TRUE(pixel.has_value());
      // Copies of a landmark in two tiles are rounded apart by up to 2 mm an axis.
      EXPECT_LT((pixel->cast<float>() - image.pixels.at(keypoint_idx)).norm(), 2.0f);
      ++num_observations;
    }
  }
  EXPECT_EQ(summary["observations"], num_observations);
}

TEST_F(ExportVerb, TextAndBinaryModelsAreTheSame) {
  ASSERT_EQ(Export({"--colmap", File("a")}).exit_code, 0);
  ASSERT_EQ(Export({"--colmap", File("b"), "--text"}).exit_code, 0);
  const ColmapModel a = ReadColmapModel(File("a")), b = ReadColmapModel(File("b"));
  EXPECT_TRUE(std::filesystem::exists(File("b/points3D.txt")));
  ASSERT_EQ(a.images.size(), b.images.size());
  for (size_t i = 0; i < a.images.size(); ++i) {
    EXPECT_EQ(a.images[i].name, b.images[i].name);
    EXPECT_EQ(a.images[i].pixels, b.images[i].pixels);
  }
  ASSERT_EQ(a.points.size(), b.points.size());
  for (size_t i = 0; i < a.points.size(); ++i) {
    EXPECT_EQ(a.points[i].x_in_world, b.points[i].x_in_world);
    EXPECT_EQ(a.points[i].track, b.points[i].track);
  }
  EXPECT_THAT(a.images[0].name, ::testing::AnyOf(StartsWith("monday/"), StartsWith("tuesday/")));
}

TEST_F(ExportVerb, TextModelsRefuseBlanksInNames) {
  const std::string map = File("blank.gpkg");
  const auto make_map = [&map] {
    const StreetWorld world({.length_m = 200.0, .keyframe_step_m = 5.0});
    Reconstruction street = world.Reconstruct();
    street.images[0].name = "my photo.jpg";
    IngestOptions ingest;
    ingest.session_name = "monday";
    MapStore store = MapStore::Create(map);
    IngestSession(street, world.EcefFromWorld(), ingest, &store, {});
  };
  ASSERT_EQ(RunInChild(make_map), 0);
  const Finished refused = RunCairn({"export", map, "--colmap", File("blank_text"), "--text"});
  EXPECT_NE(refused.exit_code, 0);
  EXPECT_THAT(refused.err, HasSubstr("'my photo.jpg', which has a blank"));
  EXPECT_EQ(RunCairn({"export", map, "--colmap", File("blank")}).exit_code, 0);
}

TEST_F(ExportVerb, EachLandmarkIsAPointOnce) {
  ASSERT_EQ(Export({"--ply", File("all.ply"), "--frame", "ecef"}).exit_code, 0);
  const MapStore store = MapStore::Open(MapPath(), OpenMode::kReadOnly);
  const MapSnapshot map = store.Snapshot();
  std::set<uint64_t> ids;
  size_t num_in_tiles = 0;
  for (const TileRecord& record : map.AllTiles(100)) {
    for (const LandmarkId id : DecodeTile(map.LoadPayload(record.payload_id)).landmark_ids) {
      ids.insert(Value(id));
      ++num_in_tiles;
    }
  }
  EXPECT_GT(num_in_tiles, ids.size());  // The street crosses the border of two tiles.
  const std::string ply = TextOf(File("all.ply"));
  EXPECT_THAT(ply, StartsWith("ply\nformat binary_little_endian 1.0\n"));
  EXPECT_THAT(ply, HasSubstr(fmt::format("element vertex {:012}\n", ids.size())));
  const std::string end = "end_header\n";
  const size_t begin = ply.find(end) + end.size();
  constexpr size_t kPointBytes = 3 * 8 + 3 + 4 + 4;
  ASSERT_EQ(ply.size() - begin, ids.size() * kPointBytes);
  Eigen::Vector3d x_in_ecef;
  std::memcpy(x_in_ecef.data(), ply.data() + begin, sizeof(double) * 3);
  EXPECT_LT(GroundDistanceM(GeodeticFromEcef(x_in_ecef), Origin()), 300.0);
}

TEST_F(ExportVerb, GeoJsonHasKeyframesAndTiles) {
  const Finished finished = Export({"--keyframes", File("k.geojson"), "--coverage",
                                    File("c.geojson"), "--session", "tuesday", "--json"});
  ASSERT_EQ(finished.exit_code, 0) << finished.err;
  const auto keyframes = nlohmann::json::parse(TextOf(File("k.geojson")));
  EXPECT_EQ(keyframes["type"], "FeatureCollection");
  ASSERT_GT(keyframes["features"].size(), 0u);
  for (const auto& feature : keyframes["features"]) {
    EXPECT_EQ(feature["properties"]["session"], "tuesday");
    EXPECT_NEAR(feature["geometry"]["coordinates"][0].get<double>(), Origin().lon_deg(), 0.01);
    EXPECT_NEAR(feature["geometry"]["coordinates"][2].get<double>(), Origin().h_m + 1.6, 0.5);
    // The street leads east, and views turn by half a radian to either side.
    EXPECT_NEAR(feature["properties"]["heading_deg"].get<double>(), 90.0, 30.0);
  }
  const auto tiles = nlohmann::json::parse(TextOf(File("c.geojson")));
  EXPECT_GE(tiles["features"].size(), 2u);
  EXPECT_EQ(tiles["features"][0]["geometry"]["coordinates"][0].size(), 5u);
}

TEST_F(ExportVerb, TheFrameOfTheMapIsItsFirstKeyframe) {
  const Finished finished = Export({"--ply", File("own.ply"), "--json"});
  ASSERT_EQ(finished.exit_code, 0) << finished.err;
  const auto frame = nlohmann::json::parse(finished.out)["frame"];
  EXPECT_EQ(frame["name"], "enu");
  EXPECT_NEAR(frame["origin"]["lat"].get<double>(), Origin().lat_deg(), 1e-5);
  EXPECT_EQ(frame["origin"]["h"].get<double>(), 410.0);
  const MapStore store = MapStore::Open(MapPath(), OpenMode::kReadOnly);
  EXPECT_EQ(MapOrigin(store.Snapshot()).h_m, 410.0);
}

TEST_F(ExportVerb, HasHelpWithAnExample) {
  EXPECT_THAT(RunCairn({"export", "--help"}).out, HasSubstr("Example:\n  cairn export"));
}

TEST_F(ExportVerb, FaultsAreNamedAndLeaveNothing) {
  EXPECT_EQ(Export({}).exit_code, 2);
  const Finished none = Export({"--ply", File("none/x.ply")});
  EXPECT_EQ(none.exit_code, 6) << none.err;
  const Finished unknown = Export({"--ply", File("x.ply"), "--session", "sunday"});
  EXPECT_EQ(unknown.exit_code, 4);
  EXPECT_THAT(unknown.err, HasSubstr("no session 'sunday'"));
  EXPECT_FALSE(std::filesystem::exists(File("x.ply")));
}

// What `cairn ingest` makes of a street without positions, written by COLMAP in some frame.
class PlacedModel : public ::testing::Test {
 protected:
  // The model stands in the frame that `enu` is turned into.
  void WriteModel(const Sim3d& world_from_enu) {
    street_ = StreetWorld({.world_from_enu = world_from_enu});
    Reconstruction reconstruction = street_.Reconstruct();
    for (ReconImage& image : reconstruction.images) {
      image.gps.reset();
    }
    WriteColmapModel(reconstruction, dir_.path().string(), ColmapModelFormat::kBinary);
    WriteColmapDatabase(reconstruction, dir_.File("database.db"), {});
  }

  Finished Ingest(const std::vector<std::string>& more) {
    MapStore::Create(dir_.File("map.gpkg"));
    std::vector<std::string> arguments = {
        "ingest",     dir_.File("map.gpkg"),    "--model",   dir_.path().string(),
        "--database", dir_.File("database.db"), "--session", "monday"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunCairn(arguments);
  }

  // The largest distance of a keyframe from where its photo was taken.
  double WorstM() const {
    const MapStore store = MapStore::Open(dir_.File("map.gpkg"), OpenMode::kReadOnly);
    const MapSnapshot map = store.Snapshot();
    const Rigid3d ecef_from_enu = EcefFromEnu(street_.options().origin);
    double worst_m = map.Sessions().empty() ? 1e9 : 0.0;
    for (const SessionRecord& session : map.Sessions()) {
      for (const KeyframeRecord& keyframe : map.KeyframesOfSession(session.id)) {
        const Rigid3d cam_from_enu = street_.KeyframePoses()[std::stoul(keyframe.image_name)];
        const Eigen::Vector3d truth = ecef_from_enu * cam_from_enu.Inverse().translation;
        worst_m = std::max(worst_m, (keyframe.cam_from_ecef.Inverse().translation - truth).norm());
      }
    }
    return worst_m;
  }

  std::string OriginText() const {
    const Geodetic& origin = street_.options().origin;
    return fmt::format("{:.10f},{:.10f},{}", origin.lat_deg(), origin.lon_deg(), origin.h_m);
  }

  TempDir dir_;
  StreetWorld street_;
};

TEST_F(PlacedModel, InEnuNeedsItsOrigin) {
  WriteModel(Sim3d());
  const Finished without = Ingest({"--frame", "enu"});
  EXPECT_EQ(without.exit_code, 2);
  EXPECT_THAT(without.err, HasSubstr("--origin"));
  std::filesystem::remove(dir_.File("map.gpkg"));
  const Finished finished = Ingest({"--frame", "enu", "--origin", OriginText()});
  ASSERT_EQ(finished.exit_code, 0) << finished.err;
  EXPECT_LT(WorstM(), 1e-4);
}

TEST_F(PlacedModel, InEcefNeedsNothing) {
  const Rigid3d ecef_from_enu = EcefFromEnu(StreetWorldOptions().origin);
  WriteModel({1.0, ecef_from_enu.rotation, ecef_from_enu.translation});
  const Finished finished = Ingest({"--frame", "ecef"});
  ASSERT_EQ(finished.exit_code, 0) << finished.err;
  EXPECT_LT(WorstM(), 1e-4);
}

TEST_F(PlacedModel, InAnotherFrameThanStatedIsRefused) {
  WriteModel(Sim3d());
  const Finished finished = Ingest({"--frame", "ecef"});
  EXPECT_EQ(finished.exit_code, 4);
  EXPECT_THAT(finished.err, HasSubstr("does not stand in the stated frame"));
}

TEST_F(PlacedModel, StandsWhereItsControlPointsAre) {
  WriteModel(StreetWorldOptions().world_from_enu);
  std::ofstream file(dir_.File("points.csv"));
  file << "point,lat_deg,lon_deg,h_m,image,x_px,y_px,accuracy_m\n";
  const Reconstruction street = street_.Reconstruct();
  for (const Eigen::Vector3d& x_in_enu : {Eigen::Vector3d(20, 8, 2), Eigen::Vector3d(35, -8, 6),
                                          Eigen::Vector3d(50, 8, 4), Eigen::Vector3d(60, -8, 1)}) {
    const Geodetic position = GeodeticFromEcef(EcefFromEnu(street_.options().origin) * x_in_enu);
    for (const ReconImage& image : street.images) {
      const auto pixel = street_.camera().Project(image.cam_from_world *
                                                  (street_.options().world_from_enu * x_in_enu));
      if (pixel && street_.camera().Contains(*pixel)) {
        file << fmt::format("p{},{:.11f},{:.11f},{:.5f},{},{:.4f},{:.4f},0.02\n", x_in_enu.x(),
                            position.lat_deg(), position.lon_deg(), position.h_m, image.name,
                            pixel->x(), pixel->y());
      }
    }
  }
  file.close();
  const Finished finished = Ingest({"--control", dir_.File("points.csv"), "--json"});
  ASSERT_EQ(finished.exit_code, 0) << finished.err;
  EXPECT_EQ(nlohmann::json::parse(finished.out)["georegistration"]["inliers"], 4);
  EXPECT_LT(WorstM(), 0.01);
}

}  // namespace
}  // namespace cairn::testing
