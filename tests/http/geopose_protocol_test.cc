// Tests requests that real clients of GeoPoseProtocol send.
#include "http/json/geopose_protocol.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "core/angles.h"
#include "core/geoid.h"
#include "core/wire/base64.h"
#include "core/wire/json_error.h"
#include "core/wire/problem.h"

namespace cairn {
namespace {

using ::nlohmann::json;
using ::testing::HasSubstr;

constexpr double kTimeMs = 1.75e12;

// A gray picture of 64 x 48 pixels.
std::string PictureBase64() {
  std::string pgm = "P5\n64 48\n255\n" + std::string(64 * 48, 'g');
  return EncodeBase64({reinterpret_cast<const uint8_t*>(pgm.data()), pgm.size()});
}

json Camera64(const std::string& sensor_id = "cam") {
  return {{"timestamp", kTimeMs},
          {"sensorId", sensor_id},
          {"imageFormat", "JPG"},
          {"size", {64, 48}},
          {"imageBytes", PictureBase64()},
          {"params", {{"model", "PINHOLE"}, {"modelParams", {50, 50, 32, 24}}}}};
}

json Geolocation(double accuracy = 10.0) {
  return {{"timestamp", kTimeMs}, {"latitude", 55.705},   {"longitude", 13.19},
          {"altitude", 60.0},     {"accuracy", accuracy}, {"altitudeAccuracy", 5.0}};
}

json Request() {
  return {{"id", "a"},
          {"timestamp", kTimeMs},
          {"type", "geopose"},
          {"sensors", json::array()},
          {"sensorReadings", {{"cameraReadings", {Camera64()}}}}};
}

LocalizeRequest ParseGeoPose(const json& request) {
  return ParseGeoPoseRequest("application/json", request.dump(), RequestLimits{});
}

// Pointer and words of the refusal.
std::pair<std::string, std::string> RefusalOf(const json& request) {
  try {
    ParseGeoPose(request);
  } catch (const JsonError& e) {
    return {e.pointer().value_or("none"), e.what() + (" " + e.hint())};
  }
  return {"accepted", ""};
}

TEST(GeoPoseProtocol, ReadsGeolocationInBothSpellings) {
  for (const char* member : {"geolocationReadings", "geoLocationReadings"}) {
    json request = Request();
    request["sensorReadings"][member] = {Geolocation()};
    const LocalizeRequest parsed = ParseGeoPose(request);
    ASSERT_TRUE(parsed.query.prior.has_value()) << member;
    EXPECT_NEAR(parsed.query.prior->position.lat_deg(), 55.705, 1e-9);
    EXPECT_EQ(parsed.query.prior->accuracy_m, 10.0);
  }
  EXPECT_FALSE(ParseGeoPose(Request()).query.prior.has_value());
}

TEST(GeoPoseProtocol, TakesWhatIsLeftOutFromThePicture) {
  for (const json& size : {json(), json::array(), json({0, 0})}) {
    for (const json& params :
         {json(), json::object(), json{{"model", "UNKNOWN"}, {"modelParams", json::array()}},
          json{{"model", "UNKNOWN_CAMERA"}}}) {
      json request = Request();
      json& reading = request["sensorReadings"]["cameraReadings"][0];
      reading["size"] = size;
      reading["params"] = params;
      const LocalizeRequest parsed = ParseGeoPose(request);
      EXPECT_EQ(parsed.query.camera.width_px(), 64) << size << params;
      EXPECT_EQ(parsed.query.camera.height_px(), 48) << size << params;
      ASSERT_TRUE(parsed.query.focal.has_value());
      EXPECT_TRUE(parsed.query.focal->with_distortion);
    }
  }
  json fisheye = Request();
  fisheye["sensorReadings"]["cameraReadings"][0]["params"] = {{"model", "OPENCV_FISHEYE"}};
  EXPECT_EQ(RefusalOf(fisheye).first, "/sensorReadings/cameraReadings/0/params/model");
}

TEST(GeoPoseProtocol, KnowsFullOpenCv) {
  json request = Request();
  request["sensorReadings"]["cameraReadings"][0]["params"] = {
      {"model", "FULL_OPENCV"},
      {"modelParams", {50, 50, 32, 24, 0.1, 0.01, 0, 0, 0.001, 0.1, 0.01, 0.001}}};
  EXPECT_EQ(ParseGeoPose(request).query.camera.model(), CameraModel::kFullOpenCv);
}

TEST(GeoPoseProtocol, SkipsDepthImages) {
  json request = Request();
  json& readings = request["sensorReadings"]["cameraReadings"];
  const json depth = {{"imageFormat", "DEPTH"}, {"size", {8, 8}}, {"imageBytes", "AAAA"}};
  readings = {depth, Camera64()};
  const LocalizeRequest parsed = ParseGeoPose(request);
  EXPECT_EQ(parsed.query.camera.width_px(), 64);
  EXPECT_EQ(parsed.images.size(), 1u);
  readings = {depth};
  EXPECT_EQ(RefusalOf(request).first, "/sensorReadings/cameraReadings");
}

TEST(GeoPoseProtocol, Version1IsToldSo) {
  json request = Request();
  request["timestamp"] = "2020-12-26T15:19:50.413Z";
  request["sensorReadings"] = {{{"sensorId", "0"}, {"reading", Camera64()}}};
  const auto [pointer, words] = RefusalOf(request);
  EXPECT_EQ(pointer, "/sensorReadings");
  EXPECT_THAT(words, HasSubstr("GeoPoseProtocol 1"));
  EXPECT_THAT(words, HasSubstr("cameraReadings"));
}

TEST(GeoPoseProtocol, ReadingsThatSayTheyAreInvalidDoNotCount) {
  json request = Request();
  json& readings = request["sensorReadings"]["geolocationReadings"];
  readings = {Geolocation(-1.0)};
  EXPECT_FALSE(ParseGeoPose(request).query.prior.has_value());
  readings = {{{"latitude", 0}, {"longitude", 0}, {"accuracy", 0}}};
  EXPECT_FALSE(ParseGeoPose(request).query.prior.has_value());
  readings = {Geolocation(-1.0), Geolocation(20.0)};
  EXPECT_EQ(ParseGeoPose(request).query.prior->accuracy_m, 20.0);
  readings = {Geolocation()};
  readings[0]["altitudeAccuracy"] = -1.0;
  EXPECT_FALSE(ParseGeoPose(request).query.prior->height_sigma_m.has_value());
  EXPECT_TRUE(ParseGeoPose(request).query.prior.has_value());
}

TEST(GeoPoseProtocol, TheReadingNearestInTimeCountsThenTheMostAccurate) {
  json request = Request();
  json old = Geolocation(1.0);
  old["timestamp"] = kTimeMs - 60'000;
  request["sensorReadings"]["geolocationReadings"] = {old, Geolocation(30.0), Geolocation(12.0)};
  EXPECT_EQ(ParseGeoPose(request).query.prior->accuracy_m, 12.0);
}

TEST(GeoPoseProtocol, AltitudesAreEllipsoidalButMayBeAboveTheSeaUnlessTheySay) {
  const Geodetic lund = Geodetic::FromDegrees(55.705, 13.19, 0.0);
  const double geoid_m = Geoid::Egm96().HeightM(lund.lat_rad, lund.lon_rad);
  json request = Request();
  json& reading = request["sensorReadings"]["geolocationReadings"][0];
  reading = Geolocation();
  const auto prior = [&] { return *ParseGeoPose(request).query.prior; };
  EXPECT_EQ(prior().position.h_m, 60.0);
  EXPECT_NEAR(*prior().height_sigma_m, std::hypot(5.0, geoid_m), 1e-6);
  reading["altitudeReference"] = "ellipsoid";
  EXPECT_EQ(prior().position.h_m, 60.0);
  EXPECT_EQ(prior().height_sigma_m, 5.0);
  reading["altitudeReference"] = "msl";
  EXPECT_NEAR(prior().position.h_m, 60.0 + geoid_m, 1e-6);
  EXPECT_EQ(prior().height_sigma_m, 5.0);
  reading["altitudeReference"] = "sea";
  EXPECT_EQ(RefusalOf(request).first, "/sensorReadings/geolocationReadings/0/altitudeReference");
}

TEST(GeoPoseProtocol, PriorPosesStandInForGpsAndGrowWithAge) {
  json request = Request();
  request["priorPoses"] = {{{"id", "b"},
                            {"timestamp", kTimeMs - 10'000},
                            {"accuracy", {{"position", 0.5}, {"orientation", 1.0}}},
                            {"geopose",
                             {{"position", {{"lat", 55.7}, {"lon", 13.2}, {"h", 90.0}}},
                              {"quaternion", {{"x", 0}, {"y", 0}, {"z", 0}, {"w", 1}}}}}}};
  const auto prior = ParseGeoPose(request).query.prior;
  ASSERT_TRUE(prior.has_value());
  EXPECT_NEAR(prior->position.lat_deg(), 55.7, 1e-9);
  EXPECT_EQ(prior->position.h_m, 90.0);
  EXPECT_NEAR(prior->accuracy_m, 0.5 + 30.0, 1e-9);
  // GPS that is known better wins, and the other way round.
  request["sensorReadings"]["geolocationReadings"] = {Geolocation(10.0)};
  EXPECT_NEAR(ParseGeoPose(request).query.prior->position.lat_deg(), 55.705, 1e-9);
  request["priorPoses"][0]["timestamp"] = kTimeMs - 1000;
  EXPECT_NEAR(ParseGeoPose(request).query.prior->position.lat_deg(), 55.7, 1e-9);
  // The JavaScript client's word for an unknown accuracy.
  request["priorPoses"][0]["accuracy"]["position"] = std::numeric_limits<double>::max();
  EXPECT_NEAR(ParseGeoPose(request).query.prior->position.lat_deg(), 55.705, 1e-9);
}

json Turn(const Eigen::Vector3d& axis, double angle_deg) {
  const Eigen::Quaterniond q(Eigen::AngleAxisd(angle_deg * kRadPerDeg, axis));
  return {{"x", q.x()}, {"y", q.y()}, {"z", q.z()}, {"w", q.w()}};
}

json SensorOnRig(const char* id, const char* type, const json& rotation, double x_m = 0.0) {
  return {{"id", id},
          {"type", type},
          {"rigIdentifier", "car"},
          {"rigRotation", rotation},
          {"rigTranslation", {{"x", x_m}, {"y", 0}, {"z", 0}}}};
}

TEST(GeoPoseProtocol, CamerasOfOneRigAreOneQuery) {
  json request = Request();
  request["sensors"] = {SensorOnRig("cam", "camera", Turn(Eigen::Vector3d::UnitY(), 90.0), 1.0),
                        SensorOnRig("left", "camera", Turn(Eigen::Vector3d::UnitZ(), 90.0), 2.0),
                        {{"id", "elsewhere"},
                         {"type", "camera"},
                         {
                             "rigIdentifier",
                             "",
                         }}};
  json late = Camera64("left");
  late["timestamp"] = kTimeMs + 500;
  json unknown = Camera64("left");
  unknown.erase("params");
  request["sensorReadings"]["cameraReadings"] = {
      Camera64("cam"), Camera64("elsewhere"), late, unknown, Camera64("left"), Camera64("left")};
  const LocalizeRequest parsed = ParseGeoPose(request);
  ASSERT_EQ(parsed.query.other_cameras.size(), 1u);
  EXPECT_EQ(parsed.images.size(), 2u);
  const Rigid3d cam_from_rig(
      Eigen::Quaterniond(Eigen::AngleAxisd(kPi / 2, Eigen::Vector3d::UnitY())),
      Eigen::Vector3d(1, 0, 0));
  const Rigid3d left_from_rig(
      Eigen::Quaterniond(Eigen::AngleAxisd(kPi / 2, Eigen::Vector3d::UnitZ())),
      Eigen::Vector3d(2, 0, 0));
  const Eigen::Vector3d x_in_rig(0.3, -2.0, 7.0);
  EXPECT_LT((parsed.query.other_cameras[0].cam_from_first * (cam_from_rig * x_in_rig) -
             left_from_rig * x_in_rig)
                .norm(),
            1e-9);
  // Cameras that do not say how they are mounted stay apart.
  request["sensors"] = json::array();
  EXPECT_TRUE(ParseGeoPose(request).query.other_cameras.empty());
}

TEST(GeoPoseProtocol, TheAccelerometerOfAPhoneIsGravity) {
  json request = Request();
  json& camera = request["sensorReadings"]["cameraReadings"][0];
  request["sensorReadings"]["accelerometerReadings"] = {
      {{"timestamp", kTimeMs}, {"x", 0.0}, {"y", 9.81}, {"z", 0.0}}};
  // Nobody says how the picture lies in the device.
  EXPECT_FALSE(ParseGeoPose(request).query.down_in_cam.has_value());
  // Upright in portrait: down is down in the picture.
  camera["imageOrientation"] = {{"mirrored", false}, {"rotation", 0}};
  ASSERT_TRUE(ParseGeoPose(request).query.down_in_cam.has_value());
  EXPECT_LT((*ParseGeoPose(request).query.down_in_cam - Eigen::Vector3d(0, 1, 0)).norm(), 1e-9);
  // The sensor's landscape pixels, to be turned by 90 degrees clockwise: what is right in them ends
  // up below.
  camera["imageOrientation"]["rotation"] = 90;
  EXPECT_LT((*ParseGeoPose(request).query.down_in_cam - Eigen::Vector3d(1, 0, 0)).norm(), 1e-9);
  camera["imageOrientation"]["rotation"] = -90;
  EXPECT_LT((*ParseGeoPose(request).query.down_in_cam - Eigen::Vector3d(-1, 0, 0)).norm(), 1e-9);
  // Lying on its back, the camera looks down.
  request["sensorReadings"]["accelerometerReadings"][0] = {{"x", 0}, {"y", 0}, {"z", 9.81}};
  EXPECT_LT((*ParseGeoPose(request).query.down_in_cam - Eigen::Vector3d(0, 0, 1)).norm(), 1e-9);
  // In motion, of another unit, or of another time.
  for (const json& reading :
       {json{{"x", 0}, {"y", 11.0}, {"z", 0}}, json{{"x", 0}, {"y", -1.0}, {"z", 0}},
        json{{"timestamp", kTimeMs + 5000}, {"x", 0}, {"y", 9.81}, {"z", 0}}}) {
    request["sensorReadings"]["accelerometerReadings"][0] = reading;
    EXPECT_FALSE(ParseGeoPose(request).query.down_in_cam.has_value()) << reading;
  }
}

TEST(GeoPoseProtocol, TheAccelerometerOfARigIsGravity) {
  json request = Request();
  // The accelerometer's z points up where the camera's y points down.
  request["sensors"] = {SensorOnRig("cam", "camera", Turn(Eigen::Vector3d::UnitX(), 0.0)),
                        SensorOnRig("acc", "accelerometer", Turn(Eigen::Vector3d::UnitX(), 90.0))};
  request["sensorReadings"]["accelerometerReadings"] = {
      {{"sensorId", "acc"}, {"x", 0.0}, {"y", 0.0}, {"z", -9.81}}};
  const auto down = ParseGeoPose(request).query.down_in_cam;
  ASSERT_TRUE(down.has_value());
  EXPECT_LT((*down - Eigen::Vector3d(0, 1, 0)).norm(), 1e-9);
}

TEST(GeoPoseProtocol, RotationsOfThePictureTurnTheAnswer) {
  json request = Request();
  json& camera = request["sensorReadings"]["cameraReadings"][0];
  camera["imageOrientation"] = {{"mirrored", false}, {"rotation", 90}};
  const LocalizeRequest turned = ParseGeoPose(request);
  camera.erase("imageOrientation");
  const LocalizeRequest as_sent = ParseGeoPose(request);
  // A level camera that looks north, in a picture that lies on its side: what is down in the world
  // is right in the pixels.
  LocalizeResult result;
  result.localized = true;
  const Geodetic lund = Geodetic::FromDegrees(55.705, 13.19, 60.0);
  Eigen::Matrix3d sent_from_enu;
  sent_from_enu << 0, 0, -1, -1, 0, 0, 0, 1, 0;
  result.cam_from_ecef =
      Rigid3d(sent_from_enu, Eigen::Vector3d::Zero()) * EcefFromEnu(lund).Inverse();
  const auto up_of = [&](const LocalizeRequest& parsed) {
    const json q = json::parse(GeoPoseResponseJson(result, parsed))["geopose"]["quaternion"];
    return Eigen::Quaterniond(q["w"], q["x"], q["y"], q["z"]) * Eigen::Vector3d::UnitZ();
  };
  EXPECT_NEAR(up_of(turned).z(), 1.0, 1e-9);   // FLU: the upright camera's up is up.
  EXPECT_NEAR(up_of(as_sent).z(), 0.0, 1e-9);  // The picture's own up lies level.
  camera["imageOrientation"] = {{"rotation", 45}};
  EXPECT_EQ(RefusalOf(request).first, "/sensorReadings/cameraReadings/0/imageOrientation/rotation");
}

TEST(GeoPoseProtocol, TheOgcGeoPoseIsThePoseAlone) {
  LocalizeResult result;
  result.localized = true;
  const Geodetic lund = Geodetic::FromDegrees(55.705, 13.19, 60.0);
  result.cam_from_ecef = EcefFromEnu(lund).Inverse();
  const json geopose = json::parse(OgcGeoPoseJson(result, ParseGeoPose(Request())));
  EXPECT_EQ(geopose.size(), 2u);
  EXPECT_NEAR(geopose["position"]["h"].get<double>(), 60.0, 1e-6);
  EXPECT_EQ(geopose["quaternion"].size(), 4u);
  EXPECT_TRUE(WantsOgcGeoPose("application/geopose+json, */*"));
  EXPECT_FALSE(WantsOgcGeoPose("application/json"));
  EXPECT_FALSE(WantsOgcGeoPose("application/geopose+json;q=0"));
}

TEST(GeoPoseRequest, ReadsWhatTheReferenceClientSends) {
  // Fractions of milliseconds, RGBA32 for a JPEG, 0 for unknown accuracies, empty privacy.
  const LocalizeRequest request = ParseGeoPoseRequest("application/json", R"({
      "type":"geopose","id":"8a","timestamp":1750939398316.25,
      "sensors":[{"type":"camera","id":"cam"},{"type":"geolocation","id":"gps"}],
      "sensorReadings":{
        "cameraReadings":[{"timestamp":1.5,"sensorId":"cam","privacy":{},"sequenceNumber":1,
          "imageFormat":"RGBA32","size":[640,480],"imageBytes":"data:image/jpeg;base64,Zm9v",
          "imageOrientation":{"mirrored":false,"rotation":0},
          "params":{"model":"PINHOLE","modelParams":[500,500,320,240],"minMaxDepth":[]}}],
        "geolocationReadings":[{"latitude":47.5,"longitude":8.5,"altitude":400,"accuracy":0,
          "altitudeAccuracy":0,"heading":0,"speed":0}],
        "wifiReadings":[]},
      "priorPoses":[]})",
                                                      RequestLimits{});
  EXPECT_EQ(request.query.id, "8a");
  EXPECT_EQ(request.timestamp_ms, 1750939398316);
  ASSERT_EQ(request.images.size(), 1u);
  EXPECT_EQ(request.images[0].bytes, (std::vector<uint8_t>{'f', 'o', 'o'}));
  EXPECT_EQ(request.query.camera.focal_px(), 500.0);
  ASSERT_TRUE(request.query.prior.has_value());
  EXPECT_EQ(request.query.prior->accuracy_m, 25.0);
  EXPECT_FALSE(request.query.prior->height_sigma_m.has_value());
}

TEST(GeoPoseRequest, NamesWhatIsMissing) {
  const std::pair<const char*, const char*> cases[] = {
      {"{}", "/sensorReadings"},
      {R"({"type":"orb","sensorReadings":{}})", "/type"},
      {R"({"sensorReadings":{"cameraReadings":[]}})", "/sensorReadings/cameraReadings"},
      {R"({"sensorReadings":{"cameraReadings":[{"size":[1,1]}]}})",
       "/sensorReadings/cameraReadings/0/imageBytes"},
      {R"({"sensorReadings":{"cameraReadings":[{"imageBytes":"Zm9v"}]}})",
       "/sensorReadings/cameraReadings/0/size"},
      {R"({"sensorReadings":{"cameraReadings":[{"size":[9,9],"imageOrientation":{"mirrored":true},
           "params":{"model":"SIMPLE_PINHOLE","modelParams":[9,4,4]}}]}})",
       "/sensorReadings/cameraReadings/0/imageOrientation/mirrored"},
      {R"({"sensorReadings":{"cameraReadings":[{"size":[9,9],"imageBytes":"?",
           "params":{"model":"SIMPLE_PINHOLE","modelParams":[9,4,4]}}]}})",
       "/sensorReadings/cameraReadings/0/imageBytes"},
  };
  for (const auto& [json, pointer] : cases) {
    try {
      ParseGeoPoseRequest("application/json", json, RequestLimits{});
      ADD_FAILURE() << json;
    } catch (const Error& e) {
      EXPECT_EQ(PublicError(e).pointer(), pointer);
    }
  }
}

TEST(GeoPoseContentType, FollowsTheAcceptHeader) {
  EXPECT_EQ(GeoPoseContentType("application/vnd.oscp+json;version=2.0;"),
            "application/vnd.oscp+json;version=2.0");
  EXPECT_EQ(GeoPoseContentType("*/*"), "application/json");
  EXPECT_EQ(GeoPoseContentType(""), "application/json");
}

}  // namespace
}  // namespace cairn
