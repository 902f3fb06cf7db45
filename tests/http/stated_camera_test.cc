#include "core/wire/stated_camera.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "core/wire/json_error.h"
#include "http/json/geopose_protocol.h"
#include "http/json/localize_request.h"

namespace cairn {
namespace {

StatedCamera Read(const std::string& json) {
  const JsonDocument document = ParseJson(json);
  return ReadStatedCamera(JsonReader(document));
}

TEST(StatedCamera, IsTakenAtItsWordByDefault) {
  const StatedCamera stated =
      Read(R"({"model":"PINHOLE","size":[640,480],"modelParams":[500,501,320,240]})");
  EXPECT_EQ(stated.camera.params(), (std::vector<double>{500, 501, 320, 240}));
  EXPECT_FALSE(stated.focal);
}

TEST(StatedCamera, WithoutParametersIsUnknown) {
  for (const char* json : {R"({"size":[640,480]})", R"({"size":[640,480],"focalLength":"unknown"})",
                           R"({"size":[640,480],"model":"SIMPLE_PINHOLE","modelParams":null})"}) {
    const StatedCamera stated = Read(json);
    EXPECT_EQ(stated.camera.model(), CameraModel::kSimpleRadial);
    EXPECT_EQ(stated.camera.params(), (std::vector<double>{0.85 * 640, 320, 240, 0}));
    ASSERT_TRUE(stated.focal);
    EXPECT_TRUE(stated.focal->with_distortion);
    EXPECT_EQ(stated.focal->log_sigma, FocalPrior::kUnknownLogSigma);
  }
}

TEST(StatedCamera, MayBeKnownButForItsFocalLength) {
  const StatedCamera stated = Read(
      R"({"model":"RADIAL","size":[640,480],"modelParams":[123,310,250,-0.1,0.01],
          "focalLength":"unknown"})");
  EXPECT_EQ(stated.camera.params(), (std::vector<double>{0.85 * 640, 310, 250, -0.1, 0.01}));
  ASSERT_TRUE(stated.focal);
  EXPECT_FALSE(stated.focal->with_distortion);
}

TEST(StatedCamera, SaysHowUncertainItsFocalLengthIs) {
  const StatedCamera stated = Read(
      R"({"model":"SIMPLE_PINHOLE","size":[640,480],"modelParams":[500,320,240],
          "focalLengthSigma":0.1})");
  EXPECT_EQ(stated.camera.focal_px(), 500.0);
  ASSERT_TRUE(stated.focal);
  EXPECT_EQ(stated.focal->log_sigma, 0.1);
}

TEST(StatedCamera, RefusesWhatMakesNoSenseWithThePointerOfTheFault) {
  const std::string known = R"("model":"SIMPLE_PINHOLE","size":[640,480],"modelParams":[500,9,9])";
  const std::vector<std::pair<std::string, std::string>> wrong = {
      {R"({"size":[640,480],"focalLengthSigma":0.1})", "/focalLengthSigma"},
      {"{" + known + R"(,"focalLength":"unknown","focalLengthSigma":0.1})", "/focalLengthSigma"},
      {"{" + known + R"(,"focalLengthSigma":-0.1})", "/focalLengthSigma"},
      {"{" + known + R"(,"focalLengthSigma":0})", "/focalLengthSigma"},
      {"{" + known + R"(,"focalLengthSigma":0.6})", "/focalLengthSigma"},
      {"{" + known + R"(,"focalLengthSigma":"0.1"})", "/focalLengthSigma"},
      {"{" + known + R"(,"focalLengthSigma":[0.1]})", "/focalLengthSigma"},
      {"{" + known + R"(,"focalLength":500})", "/focalLength"},
      {"{" + known + R"(,"focalLength":"500"})", "/focalLength"},
      {"{" + known + R"(,"focalLengthSd":0.1})", "/focalLengthSd"},
      {R"({"size":[640,480],"modelParams":[500,320,240]})", "/modelParams"},
      {R"({"size":[640,480],"model":"OPENCV_FISHEYE"})", "/model"},
      {R"({"size":[640,480],"model":"FOV"})", "/model"},
      {R"({"size":[640,0]})", "/size/1"},
      {R"({"focalLength":"unknown"})", "/size"},
  };
  for (const auto& [json, pointer] : wrong) {
    try {
      Read(json);
      ADD_FAILURE() << json << ": accepted";
    } catch (const JsonError& e) {
      EXPECT_EQ(e.pointer(), pointer) << json << ": " << e.what();
    }
  }
  EXPECT_THROW(Read("{" + known + R"(,"focalLengthSigma":NaN})"), JsonError);
}

TEST(StatedCamera, HasToBeKnownInARig) {
  const std::string camera =
      R"("model":"SIMPLE_PINHOLE","size":[640,480],"modelParams":[500,320,240])";
  const std::string place =
      R"("camFromFirst":{"quaternion":{"x":0,"y":0,"z":0,"w":1},"translation":[1,0,0]})";
  const auto pointer_of = [&](const std::string& first, const std::string& other) -> std::string {
    try {
      ParseLocalizeRequest("application/json",
                           R"({"camera":{)" + first +
                               R"(},"image":{"data":"Zm9v"},"rig":[{"camera":{)" + other + "}," +
                               place + R"(,"image":{"data":"Zm9v"}}]})",
                           RequestLimits{});
    } catch (const JsonError& e) {
      return e.pointer().value_or("none");
    }
    return "accepted";
  };
  EXPECT_EQ(pointer_of(camera, camera), "accepted");
  EXPECT_EQ(pointer_of(camera + R"(,"focalLength":"unknown")", camera), "/camera/focalLength");
  EXPECT_EQ(pointer_of(camera, camera + R"(,"focalLengthSigma":0.1)"),
            "/rig/0/camera/focalLengthSigma");
  EXPECT_EQ(pointer_of(R"("size":[640,480])", camera), "/camera/model");
}

TEST(GeoPoseRequest, WithoutCameraParametersTheCameraIsUnknown) {
  const LocalizeRequest request = ParseGeoPoseRequest("application/json", R"({
      "id":"8a","timestamp":1,
      "sensorReadings":{"cameraReadings":[{"sensorId":"cam","size":[640,480],
        "imageBytes":"Zm9v"}]}})",
                                                      RequestLimits{});
  EXPECT_EQ(request.query.camera.focal_px(), 0.85 * 640);
  ASSERT_TRUE(request.query.focal);
  EXPECT_TRUE(request.query.focal->with_distortion);
}

}  // namespace
}  // namespace cairn
