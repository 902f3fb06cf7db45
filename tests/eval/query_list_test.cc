#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/error.h"
#include "eval/eval_query.h"
#include "support/temp_dir.h"

namespace cairn {
namespace {

EvalQuery FullQuery(const std::filesystem::path& folder) {
  EvalQuery query;
  query.name = "one.png";
  query.image_path = (folder / "photos" / "one.png").string();
  query.query.camera = Camera(CameraModel::kRadial, 800, 600, {500.0, 400.25, 299.5, 0.01, -0.002});
  query.cam_from_ecef = Rigid3d(ExpSo3(Eigen::Vector3d(0.7, -1.1, 0.2)), Eigen::Vector3d::Zero()) *
                        EcefFromEnu(Geodetic::FromDegrees(-33.5, 151.2, 41.25)).Inverse();
  query.query.prior = {Geodetic::FromDegrees(-33.5001, 151.2001, 40.0), 15.5, 4.5};
  query.query.down_in_cam = Eigen::Vector3d(0.1, 0.9, 0.2).normalized();
  return query;
}

TEST(QueryList, RoundTrips) {
  const testing::TempDir dir;
  const EvalQuery full = FullQuery(dir.path());
  EvalQuery bare = full;
  bare.name = "two";
  bare.query.prior.reset();
  bare.query.down_in_cam.reset();
  WriteQueryList(dir.File("list.json"), {full, bare});
  const std::vector<EvalQuery> read = ReadQueryList(dir.File("list.json"));
  ASSERT_EQ(read.size(), 2u);
  EXPECT_EQ(read[0].name, full.name);
  EXPECT_EQ(read[0].image_path, full.image_path);
  EXPECT_EQ(read[0].query.camera.model(), CameraModel::kRadial);
  EXPECT_EQ(read[0].query.camera.params(), full.query.camera.params());
  EXPECT_EQ(read[0].query.camera.width_px(), 800);
  EXPECT_EQ(read[0].query.camera.height_px(), 600);
  EXPECT_LT((read[0].cam_from_ecef.Inverse().translation - full.cam_from_ecef.Inverse().translation)
                .norm(),
            1e-6);
  EXPECT_LT(RotationAngleRad(read[0].cam_from_ecef.rotation, full.cam_from_ecef.rotation), 1e-9);
  ASSERT_TRUE(read[0].query.prior.has_value());
  EXPECT_NEAR(read[0].query.prior->position.lat_rad, full.query.prior->position.lat_rad, 1e-12);
  EXPECT_EQ(read[0].query.prior->accuracy_m, 15.5);
  EXPECT_EQ(read[0].query.prior->height_sigma_m, 4.5);
  EXPECT_EQ(*read[0].query.down_in_cam, *full.query.down_in_cam);
  EXPECT_FALSE(read[1].query.prior.has_value());
  EXPECT_FALSE(read[1].query.down_in_cam.has_value());
}

TEST(QueryList, AFeatureFileMayStandForThePhoto) {
  const testing::TempDir dir;
  EvalQuery query = FullQuery(dir.path());
  query.image_path.clear();
  query.features_path = (dir.path() / "features" / "one.features").string();
  WriteQueryList(dir.File("list.json"), {query});
  const std::vector<EvalQuery> read = ReadQueryList(dir.File("list.json"));
  ASSERT_EQ(read.size(), 1u);
  EXPECT_EQ(read[0].image_path, "");
  EXPECT_EQ(read[0].features_path, query.features_path);
}

TEST(QueryList, PathsAreRelativeToTheFile) {
  const testing::TempDir dir;
  WriteQueryList(dir.File("list.json"), {FullQuery(dir.path())});
  std::ifstream file(dir.File("list.json"));
  EXPECT_EQ(nlohmann::json::parse(file)["queries"][0]["image"], "photos/one.png");
  std::filesystem::create_directory(dir.path() / "moved");
  std::filesystem::rename(dir.File("list.json"), dir.path() / "moved" / "list.json");
  EXPECT_EQ(ReadQueryList((dir.path() / "moved" / "list.json").string())[0].image_path,
            (dir.path() / "moved" / "photos" / "one.png").string());
}

TEST(QueryList, MissingFileIsNotFound) {
  try {
    ReadQueryList("/nowhere/list.json");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kNotFound);
    EXPECT_THAT(error.what(), ::testing::HasSubstr("/nowhere/list.json"));
  }
}

// Damages a good list, reads it and expects a message with all the given parts.
void ExpectRefused(const std::function<void(nlohmann::json*)>& damage, const std::string& part) {
  const testing::TempDir dir;
  const std::string path = dir.File("list.json");
  WriteQueryList(path, {FullQuery(dir.path())});
  nlohmann::json json;
  std::ifstream(path) >> json;
  damage(&json);
  std::ofstream(path) << json;
  try {
    ReadQueryList(path);
    FAIL() << "accepted: " << part;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadInput);
    EXPECT_THAT(error.what(), ::testing::HasSubstr(path));
    EXPECT_THAT(error.what(), ::testing::HasSubstr(part));
  }
}

TEST(QueryList, RefusesBadFieldsByName) {
  using Json = nlohmann::json;
  const auto first = [](Json* json) -> Json& { return (*json)["queries"][0]; };
  ExpectRefused([](Json* json) { (*json)["format"] = "GPX"; }, "/format: is 'GPX'");
  ExpectRefused([](Json* json) { (*json)["version"] = 2; }, "/version: is 2");
  ExpectRefused([](Json* json) { (*json)["version"] = 1.5; }, "/version: must be an integer");
  ExpectRefused([](Json* json) { json->erase("queries"); }, "/queries: is missing");
  ExpectRefused([](Json* json) { (*json)["queries"] = 3; }, "/queries: must be an array");
  ExpectRefused([](Json* json) { *json = 7; }, "must be an object");
  ExpectRefused([&](Json* json) { first(json) = nullptr; }, "/queries/0: must be an object");
  ExpectRefused([&](Json* json) { first(json).erase("name"); }, "/queries/0/name: is missing");
  ExpectRefused([&](Json* json) { first(json)["image"] = ""; }, "/queries/0/image");
  ExpectRefused([&](Json* json) { first(json)["camera"]["model"] = "THIN_PRISM"; },
                "/queries/0/camera/model");
  ExpectRefused([&](Json* json) { first(json)["camera"]["size"] = {640}; },
                "/queries/0/camera/size: must be an array of 2");
  ExpectRefused([&](Json* json) { first(json)["camera"]["size"][0] = -3; }, "/queries/0/camera");
  ExpectRefused([&](Json* json) { first(json)["camera"]["modelParams"].push_back(1.0); },
                "/queries/0/camera/modelParams: must be an array of 5");
  ExpectRefused([&](Json* json) { first(json)["camera"]["modelParams"][0] = "f"; },
                "/queries/0/camera/modelParams/0: must be a number");
  ExpectRefused([&](Json* json) { first(json)["reference"]["position"]["lat"] = 91.0; },
                "/queries/0/reference/position");
  ExpectRefused([&](Json* json) { first(json)["reference"]["quaternion"]["w"] = 3.0; },
                "/queries/0/reference/quaternion: has length");
  ExpectRefused([&](Json* json) { first(json)["prior"].erase("accuracy"); },
                "/queries/0/prior/accuracy: is missing");
  ExpectRefused([&](Json* json) { first(json)["prior"]["accuracy"] = -1.0; }, "/queries/0");
  ExpectRefused([&](Json* json) { first(json)["gravity"] = {0.0, 3.0, 0.0}; }, "/queries/0");
  ExpectRefused(
      [&](Json* json) {
        first(json)["gravity"] = {0.0, 1.0};
      },
      "/queries/0/gravity: must be an array of 3");
}

TEST(QueryList, RefusesWhatIsNotJson) {
  const testing::TempDir dir;
  for (const char* text :
       {"", "{", "queries", "[1,2", "{\"format\": 1e999}", "\xff\xfe",
        R"({"format": "cairn query list", "version": 1, "queries": [], "queries": []})"}) {
    std::ofstream(dir.File("list.json")) << text;
    try {
      ReadQueryList(dir.File("list.json"));
      FAIL() << "accepted: " << text;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kBadInput);
      EXPECT_THAT(error.what(), ::testing::HasSubstr("list.json"));
    }
  }
}

TEST(QueryList, WritingToANonexistentFolderFails) {
  EXPECT_THROW(WriteQueryList("/nowhere/list.json", {}), Error);
}

}  // namespace
}  // namespace cairn
