#include "http/json/localize_request.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>

#include "core/wire/base64.h"
#include "core/wire/feature_codec.h"
#include "core/wire/json_error.h"
#include "core/wire/problem.h"

namespace cairn {
namespace {

constexpr char kCamera[] =
    R"("camera":{"model":"PINHOLE","size":[640,480],"modelParams":[500,501,320,240]})";
constexpr char kImage[] = R"("image":{"format":"JPG","data":"Zm9v"})";

LocalizeRequest Parse(const std::string& json) {
  return ParseLocalizeRequest("application/json", json, RequestLimits{});
}

std::string WithImage(const std::string& members) {
  return fmt::format("{{{},{},{}}}", kCamera, kImage, members);
}

std::vector<uint8_t> SmallBlob() {
  WireFeatures wire{.features = {}, .codec = "sift", .width_px = 640, .height_px = 480};
  wire.features.keypoints = {{10.0f, 20.0f, 2.0f, 0.5f}};
  wire.features.descriptors = DescriptorMatrix::Constant(1, 128, 7.0f);
  return EncodeFeatures(wire, LosslessEncoding(wire.features));
}

TEST(LocalizeRequest, ReadsEveryMember) {
  const LocalizeRequest request = Parse(WithImage(
      R"("id":"q1","timestamp":1750939398316,
         "prior":{"position":{"lat":47.5,"lon":-8.25,"h":408},"accuracy":12,"altitudeAccuracy":4},
         "gravity":[0,1,0],
         "options":{"innerFrame":"RUB","timeoutMs":500,"maxMatches":7,"include":["matches"]})"));
  EXPECT_EQ(request.query.id, "q1");
  EXPECT_EQ(request.timestamp_ms, 1750939398316);
  EXPECT_EQ(request.query.camera.model(), CameraModel::kPinhole);
  EXPECT_EQ(request.query.camera.width_px(), 640);
  EXPECT_EQ(request.query.camera.params(), (std::vector<double>{500, 501, 320, 240}));
  ASSERT_EQ(request.images.size(), 1u);
  EXPECT_EQ(request.images[0].bytes, (std::vector<uint8_t>{'f', 'o', 'o'}));
  EXPECT_EQ(request.images[0].format, "JPG");
  ASSERT_TRUE(request.query.prior.has_value());
  EXPECT_DOUBLE_EQ(request.query.prior->position.lat_deg(), 47.5);
  EXPECT_DOUBLE_EQ(request.query.prior->position.lon_deg(), -8.25);
  EXPECT_EQ(request.query.prior->position.h_m, 408.0);
  EXPECT_EQ(request.query.prior->accuracy_m, 12.0);
  EXPECT_EQ(request.query.prior->height_sigma_m, 4.0);
  EXPECT_EQ(request.query.down_in_cam, Eigen::Vector3d(0, 1, 0));
  EXPECT_EQ(request.answer.inner_frame, InnerFrame::kRub);
  EXPECT_EQ(request.timeout_ms, 500);
  EXPECT_EQ(request.answer.max_matches, 7);
  EXPECT_TRUE(request.answer.with_matches);
  EXPECT_FALSE(request.answer.with_timings);
  EXPECT_FALSE(request.answer.with_covariance);
}

TEST(LocalizeRequest, HasDefaults) {
  const LocalizeRequest request = Parse(fmt::format("{{{},{}}}", kCamera, kImage));
  EXPECT_EQ(request.query.id, "");
  EXPECT_FALSE(request.query.prior.has_value());
  EXPECT_FALSE(request.query.down_in_cam.has_value());
  EXPECT_EQ(request.timeout_ms, 2000);
  EXPECT_EQ(request.answer.inner_frame, InnerFrame::kFlu);
  EXPECT_FALSE(request.answer.with_matches);
  EXPECT_TRUE(request.answer.with_covariance);
}

TEST(LocalizeRequest, NormalizesGravityThatIsNearlyUnit) {
  const LocalizeRequest request = Parse(WithImage(R"("gravity":[0.01,1.01,0])"));
  EXPECT_NEAR(request.query.down_in_cam->norm(), 1.0, 1e-15);
}

constexpr char kCamFromFirst[] =
    R"("camFromFirst":{"quaternion":{"x":0,"y":0.6,"z":0,"w":0.8},"translation":[0.5,0,-1]})";

std::string RigJson(const std::string& own_features, const std::string& rig) {
  return fmt::format("{{{}{},\"rig\":[{}]}}", kCamera, own_features, rig);
}

std::string FeaturesMember() {
  return fmt::format(R"("features":{{"data":"{}"}})", EncodeBase64(SmallBlob()));
}

std::string MultipartRig(const std::string& rig_part_name) {
  const std::vector<uint8_t> blob = SmallBlob();
  const std::string bytes(blob.begin(), blob.end());
  const auto part = [](const std::string& name, const std::string& content) {
    return fmt::format("--B\r\nContent-Disposition: form-data; name=\"{}\"\r\n\r\n{}\r\n", name,
                       content);
  };
  return part("request", RigJson("", fmt::format("{{{},{}}}", kCamera, kCamFromFirst))) +
         part("features", bytes) + part(rig_part_name, bytes) + "--B--";
}

TEST(LocalizeRequest, ReadsARigFromJsonAndMultipartAlike) {
  const LocalizeRequest from_json =
      Parse(RigJson("," + FeaturesMember(),
                    fmt::format("{{{},{},{}}}", kCamera, kCamFromFirst, FeaturesMember())));
  const LocalizeRequest from_parts = ParseLocalizeRequest("multipart/form-data; boundary=B",
                                                          MultipartRig("rig0"), RequestLimits{});
  for (const LocalizeRequest* request : {&from_json, &from_parts}) {
    ASSERT_EQ(request->query.other_cameras.size(), 1u);
    const RigCamera& other = request->query.other_cameras[0];
    EXPECT_EQ(other.camera.params(), (std::vector<double>{500, 501, 320, 240}));
    EXPECT_EQ(other.features.size(), 1);
    EXPECT_EQ(request->query.num_features(), 2);
    EXPECT_NEAR(other.cam_from_first.rotation.y(), 0.6, 1e-12);
    EXPECT_EQ(other.cam_from_first.translation, Eigen::Vector3d(0.5, 0, -1));
  }
}

TEST(LocalizeRequest, ReadsImagesOfARig) {
  const LocalizeRequest request = Parse(
      RigJson(fmt::format(",{}", kImage),
              fmt::format("{{{},{},\"image\":{{\"data\":\"YmFy\"}}}}", kCamera, kCamFromFirst)));
  ASSERT_EQ(request.images.size(), 2u);
  EXPECT_EQ(request.images[0].bytes, (std::vector<uint8_t>{'f', 'o', 'o'}));
  EXPECT_EQ(request.images[1].bytes, (std::vector<uint8_t>{'b', 'a', 'r'}));
  EXPECT_EQ(request.images[1].format, "");
  ASSERT_EQ(request.query.other_cameras.size(), 1u);
  EXPECT_EQ(request.query.num_features(), 0);
}

TEST(LocalizeRequest, RefusesBadRigsWithThePointerOfTheFault) {
  const std::string member = fmt::format("{{{},{},{}}}", kCamera, kCamFromFirst, FeaturesMember());
  const auto pointer_of = [](const std::string& json, RequestLimits limits = {}) -> std::string {
    try {
      ParseLocalizeRequest("application/json", json, limits);
    } catch (const Error& error) {
      return PublicError(error).pointer();
    }
    return "accepted";
  };
  const std::string own = "," + FeaturesMember();
  EXPECT_EQ(pointer_of(RigJson(own, fmt::format("{{{},{}}}", kCamera, FeaturesMember()))),
            "/rig/0/camFromFirst");
  EXPECT_EQ(pointer_of(RigJson(own, fmt::format("{{{},{}}}", kCamera, kCamFromFirst))),
            "/rig/0/features");
  EXPECT_EQ(
      pointer_of(RigJson(
          own,
          fmt::format(
              R"({{{},"camFromFirst":{{"quaternion":{{"x":1,"y":1,"z":0,"w":0}},"translation":[0,0,0]}},{}}})",
              kCamera, FeaturesMember()))),
      "/rig/0/camFromFirst/quaternion");
  EXPECT_EQ(
      pointer_of(RigJson(
          own,
          fmt::format(
              R"({{{},"camFromFirst":{{"quaternion":{{"x":0,"y":0,"z":0,"w":1}},"translation":[0,0,900]}},{}}})",
              kCamera, FeaturesMember()))),
      "/rig/0/camFromFirst/translation");
  EXPECT_EQ(pointer_of(RigJson(fmt::format(",{}", kImage), member)), "/rig/0/features");
  const std::string pictured = fmt::format("{{{},{},{}}}", kCamera, kCamFromFirst, kImage);
  EXPECT_EQ(pointer_of(RigJson(own, pictured)), "/rig/0/image");
  EXPECT_EQ(pointer_of(RigJson(own, member), {.max_features = 1}), "/rig/0/features");
  std::string eight = member;
  for (int i = 0; i < 7; ++i) {
    eight += "," + member;
  }
  EXPECT_EQ(pointer_of(RigJson(own, eight)), "/rig");
  EXPECT_EQ(pointer_of(RigJson(own, member)), "accepted");
}

TEST(LocalizeRequest, RigPartsHaveToMatchTheCameras) {
  for (const char* name : {"rig1", "rig9", "rigs"}) {
    EXPECT_THROW(ParseLocalizeRequest("multipart/form-data; boundary=B", MultipartRig(name),
                                      RequestLimits{}),
                 HttpError)
        << name;
  }
}

TEST(LocalizeRequest, ReadsFeaturesFromJsonAndMultipartAlike) {
  const std::vector<uint8_t> blob = SmallBlob();
  const std::string json =
      fmt::format(R"({{{},"features":{{"codec":"sift","count":1,"encoding":"features_v1",
                  "data":"{}"}}}})",
                  kCamera, EncodeBase64(blob));
  const std::string multipart = fmt::format(
      "--B\r\nContent-Disposition: form-data; name=\"request\"\r\n\r\n{{{}}}\r\n"
      "--B\r\nContent-Disposition: form-data; name=\"features\"\r\n\r\n{}\r\n--B--",
      kCamera, std::string(blob.begin(), blob.end()));
  for (const auto& [type, body] :
       {std::pair("application/json", json), {"multipart/form-data; boundary=B", multipart}}) {
    const LocalizeRequest request = ParseLocalizeRequest(type, body, RequestLimits{});
    EXPECT_FALSE(request.has_images());
    EXPECT_EQ(request.query.codec, "sift");
    ASSERT_EQ(request.query.features.size(), 1);
    EXPECT_EQ(request.query.features.keypoints[0].x_px, 10.0f);
    EXPECT_EQ(request.query.features.descriptors(0, 127), 7.0f);
  }
}

struct BadRequest {
  const char* name;
  std::string json;
  ProblemCode problem;
  std::string pointer;
};

std::vector<BadRequest> BadDocuments() {
  using enum ProblemCode;
  return {
      {"empty", "", kInvalidJson, ""},
      {"truncated", "{", kInvalidJson, ""},
      {"trailing", "{}x", kInvalidJson, ""},
      {"not UTF-8", "{\"id\":\"\xff\xfe\"}", kInvalidJson, ""},
      {"NaN", WithImage(R"("gravity":[NaN,0,0])"), kInvalidJson, ""},
      {"infinite", WithImage(R"("gravity":[Infinity,0,0])"), kInvalidJson, ""},
      {"overflow", WithImage(R"("gravity":[1e999,0,0])"), kInvalidJson, ""},
      {"deep", std::string(1000, '['), kInvalidJson, ""},
      {"array", "[]", kInvalidField, ""},
      {"unknown member", WithImage(R"("priors":1)"), kInvalidField, "/priors"},
      {"strange member", WithImage(R"("a/b~":1)"), kInvalidField, "/a~1b~0"},
      {"no camera", fmt::format("{{{}}}", kImage), kInvalidField, "/camera"},
      {"no image", fmt::format("{{{}}}", kCamera), kInvalidField, ""},
      {"both", WithImage(R"("features":{"data":""})"), kInvalidField, ""},
  };
}

std::vector<BadRequest> BadCameras() {
  using enum ProblemCode;
  return {
      {"model", R"({"camera":{"model":"SIMPLE_DIVISION","size":[1,1],"modelParams":[]}})",
       kInvalidField, "/camera/model"},
      {"model type", R"({"camera":{"model":4,"size":[1,1],"modelParams":[]}})", kInvalidField,
       "/camera/model"},
      {"size", R"({"camera":{"model":"PINHOLE","size":[640],"modelParams":[]}})", kInvalidField,
       "/camera/size"},
      {"zero size", R"({"camera":{"model":"PINHOLE","size":[640,0],"modelParams":[]}})",
       kInvalidField, "/camera/size/1"},
      {"half pixel", R"({"camera":{"model":"PINHOLE","size":[640.5,480],"modelParams":[]}})",
       kInvalidField, "/camera/size/0"},
      {"params", R"({"camera":{"model":"PINHOLE","size":[640,480],"modelParams":[500,500,320]}})",
       kInvalidField, "/camera/modelParams"},
      {"focal", R"({"camera":{"model":"PINHOLE","size":[640,480],"modelParams":[0,1,2,3]}})",
       kInvalidField, "/camera/modelParams"},
      {"param type", R"({"camera":{"model":"PINHOLE","size":[640,480],"modelParams":[1,"1",2,3]}})",
       kInvalidField, "/camera/modelParams/1"},
  };
}

std::vector<BadRequest> BadSensorsAndOptions() {
  using enum ProblemCode;
  const auto prior = [](const std::string& members) {
    return WithImage(fmt::format(R"("prior":{{{}}})", members));
  };
  return {
      {"latitude", prior(R"("position":{"lat":91,"lon":0})"), kInvalidField, "/prior/position/lat"},
      {"longitude", prior(R"("position":{"lat":0,"lon":-180.5})"), kInvalidField,
       "/prior/position/lon"},
      {"height", prior(R"("position":{"lat":0,"lon":0,"h":1e6})"), kInvalidField,
       "/prior/position/h"},
      {"no longitude", prior(R"("position":{"lat":0})"), kInvalidField, "/prior/position/lon"},
      {"accuracy", prior(R"("position":{"lat":0,"lon":0},"accuracy":0)"), kInvalidField,
       "/prior/accuracy"},
      {"altitude accuracy", prior(R"("position":{"lat":0,"lon":0},"altitudeAccuracy":3)"),
       kInvalidField, "/prior/altitudeAccuracy"},
      {"altitude reference",
       prior(R"("position":{"lat":0,"lon":0,"h":3},"altitudeReference":"sea")"), kInvalidField,
       "/prior/altitudeReference"},
      {"image orientation", WithImage(R"("options":{"imageOrientation":"exif"})"), kInvalidField,
       "/options/imageOrientation"},
      {"gravity length", WithImage(R"("gravity":[0,9.81,0])"), kInvalidField, "/gravity"},
      {"gravity size", WithImage(R"("gravity":[0,1])"), kInvalidField, "/gravity"},
      {"gravity type", WithImage(R"("gravity":[0,"1",0])"), kInvalidField, "/gravity/1"},
      {"frame", WithImage(R"("options":{"innerFrame":"NED"})"), kInvalidField,
       "/options/innerFrame"},
      {"timeout", WithImage(R"("options":{"timeoutMs":0})"), kInvalidField, "/options/timeoutMs"},
      {"include", WithImage(R"("options":{"include":["poses"]})"), kInvalidField,
       "/options/include/0"},
      {"long id", WithImage(fmt::format(R"("id":"{}")", std::string(200, 'x'))), kInvalidField,
       "/id"},
  };
}

std::vector<BadRequest> BadImagesAndFeatures() {
  using enum ProblemCode;
  const std::string camera = kCamera;
  const std::string blob = EncodeBase64(SmallBlob());
  const auto features = [&](const std::string& members) {
    return fmt::format(R"({{{},"features":{{{}}}}})", camera, members);
  };
  return {
      {"image base64", fmt::format(R"({{{},"image":{{"data":"Zm9"}}}})", camera), kInvalidField,
       "/image/data"},
      {"empty image", fmt::format(R"({{{},"image":{{"data":""}}}})", camera), kInvalidField,
       "/image/data"},
      {"feature array", fmt::format(R"({{{},"features":[[1,2]]}})", camera), kInvalidField,
       "/features"},
      {"descriptor array", features(R"("descriptors":[[1,2]])"), kInvalidField,
       "/features/descriptors"},
      {"data array", features(R"("data":[1,2])"), kInvalidField, "/features/data"},
      {"features base64", features(R"("data":"????")"), kInvalidField, "/features/data"},
      {"not features", features(R"("data":"Zm9v")"), kInvalidFeatures, "/features"},
      {"encoding", features(R"("encoding":"json","data":"")"), kInvalidField, "/features/encoding"},
      {"other codec", features(fmt::format(R"("codec":"orb","data":"{}")", blob)), kInvalidField,
       "/features/codec"},
      {"other count", features(fmt::format(R"("count":2,"data":"{}")", blob)), kInvalidField,
       "/features/count"},
      {"other image size",
       fmt::format(R"({{"camera":{{"model":"PINHOLE","size":[320,240],
                       "modelParams":[500,500,160,120]}},"features":{{"data":"{}"}}}})",
                   blob),
       kInvalidFeatures, "/camera/size"},
  };
}

TEST(LocalizeRequest, RefusesBadRequestsWithThePointerOfTheFault) {
  for (const std::vector<BadRequest>& group :
       {BadDocuments(), BadCameras(), BadSensorsAndOptions(), BadImagesAndFeatures()}) {
    for (const BadRequest& bad : group) {
      try {
        Parse(bad.json);
        ADD_FAILURE() << bad.name << ": accepted";
      } catch (const Error& e) {
        const HttpError shown = PublicError(e);
        EXPECT_EQ(InfoOf(shown.problem()).name, std::string(InfoOf(bad.problem).name)) << bad.name;
        EXPECT_EQ(shown.pointer(), bad.pointer) << bad.name << ": " << e.what();
      }
    }
  }
}

TEST(LocalizeRequest, HeightsOfPriorsAreEllipsoidalUnlessTheySayMeanSeaLevel) {
  const auto height_m = [](const std::string& reference) {
    return Parse(WithImage(fmt::format(
                     R"("prior":{{"position":{{"lat":55.705,"lon":13.19,"h":50}}{}}})", reference)))
        .query.prior->position.h_m;
  };
  EXPECT_EQ(height_m(""), 50.0);
  EXPECT_EQ(height_m(R"(,"altitudeReference":"ellipsoid")"), 50.0);
  EXPECT_NEAR(height_m(R"(,"altitudeReference":"msl")"), 50.0 + 35.7, 0.1);
}

TEST(LocalizeRequest, RefusesOtherContentTypes) {
  for (const char* type : {"", "text/plain", "application/x-www-form-urlencoded", "image/jpeg"}) {
    try {
      ParseLocalizeRequest(type, "{}", RequestLimits{});
      ADD_FAILURE() << type;
    } catch (const HttpError& e) {
      EXPECT_EQ(e.problem(), ProblemCode::kUnsupportedMediaType);
    }
  }
}

TEST(LocalizeRequest, RefusesEveryTruncationOfAGoodBody) {
  const std::string json = WithImage(R"("id":"q","gravity":[0,1,0])");
  for (size_t size = 0; size < json.size(); ++size) {
    EXPECT_THROW(Parse(json.substr(0, size)), JsonError) << size;
  }
}

TEST(LocalizeRequest, LongJsonWaitsForItsTurn) {
  const std::string many(size_t{65} << 10, ' ');
  EXPECT_TRUE(TakesLongToParse("application/json", many));
  EXPECT_FALSE(TakesLongToParse("application/json", "{}"));
  EXPECT_FALSE(TakesLongToParse("multipart/form-data; boundary=B", many));
  EXPECT_THROW(ParseLocalizeRequest(
                   "multipart/form-data; boundary=B",
                   "--B\r\nContent-Disposition: form-data; name=\"request\"\r\n\r\n{" + many +
                       "}\r\n--B\r\nContent-Disposition: form-data; name=\"image\"\r\n\r\nx"
                       "\r\n--B--\r\n",
                   RequestLimits{}),
               HttpError);
}

// Decoding 5,000 features takes 3 ms. A client whose requests are refused because too many wait
// could otherwise hold all cores with them.
TEST(LocalizeRequest, ManyFeaturesWaitForTheirTurn) {
  const auto body_of = [](const std::string& name, size_t num_bytes) {
    return "--B\r\nContent-Disposition: form-data; name=\"" + name + "\"\r\n\r\n" +
           std::string(num_bytes, 'x') + "\r\n--B--\r\n";
  };
  const char* const type = "multipart/form-data; boundary=B";
  EXPECT_TRUE(TakesLongToParse(type, body_of("features", size_t{65} << 10)));
  EXPECT_FALSE(TakesLongToParse(type, body_of("features", size_t{60} << 10)));
  EXPECT_FALSE(TakesLongToParse(type, body_of("image", size_t{65} << 10)));
}

TEST(LocalizeRequest, PeeksAtTheTimeout) {
  const RequestLimits limits{.default_timeout_ms = 1234};
  EXPECT_EQ(PeekTimeoutMs(R"({"options":{"timeoutMs":500}})", limits), 500);
  EXPECT_EQ(PeekTimeoutMs("{\"options\":{\"timeoutMs\" :\n 70}}", limits), 70);
  EXPECT_EQ(PeekTimeoutMs(R"({"timeoutMs":99999999})", limits), 60'000);
  EXPECT_EQ(PeekTimeoutMs(R"({"timeoutMs":-5})", limits), 1);
  for (const char* without : {"", "{}", R"({"timeoutMs":"x"})", R"({"timeoutMs")",
                              R"({"id":"\"timeoutMs\":5"})", R"({"timeoutMs":99999999999})"}) {
    EXPECT_EQ(PeekTimeoutMs(without, limits), 1234) << without;
  }
}

}  // namespace
}  // namespace cairn
