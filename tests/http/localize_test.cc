// Compares localization through a running server with the same engine in this process.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

#include "core/cell_name.h"
#include "core/error.h"
#include "core/wire/base64.h"
#include "core/wire/feature_codec.h"
#include "http/client.h"
#include "http/plain_http.h"
#include "http/server_fixture.h"
#include "storage/codebook/descriptor_codec.h"

namespace cairn {
namespace {

using ::testing::HasSubstr;

class HttpLocalize : public testing::ServerFixture {
 protected:
  static LocalizeResult LocalizeHere(const LocalizeQuery& query) {
    return Localizer::Open(map_path(), {}, size_t{64} << 20).Localize(query);
  }

  static void ExpectNearTruth(const LocalizeResult& result, double x_m) {
    ASSERT_TRUE(result.localized) << NotLocalizedReasonName(result.reason);
    const Rigid3d truth = TrueCamFromEcef(x_m);
    EXPECT_LT((result.cam_from_ecef.Inverse().translation - truth.Inverse().translation).norm(),
              0.5);
    EXPECT_LT(RotationAngleRad(result.cam_from_ecef.rotation, truth.rotation), 0.02);
  }

  static void ExpectSamePose(const LocalizeResult& a, const LocalizeResult& b) {
    ASSERT_EQ(a.localized, b.localized);
    EXPECT_LT(
        (a.cam_from_ecef.Inverse().translation - b.cam_from_ecef.Inverse().translation).norm(),
        1e-6);
    EXPECT_LT(RotationAngleRad(a.cam_from_ecef.rotation, b.cam_from_ecef.rotation), 1e-8);
  }

  static nlohmann::json RequestJson(const LocalizeQuery& query) {
    const Geodetic& position = query.prior->position;
    const Eigen::Vector3d& down = *query.down_in_cam;
    return {{"id", query.id},
            {"camera",
             {{"model", CameraModelName(query.camera.model())},
              {"size", {query.camera.width_px(), query.camera.height_px()}},
              {"modelParams", query.camera.params()}}},
            {"prior",
             {{"position", {{"lat", position.lat_deg()}, {"lon", position.lon_deg()}}},
              {"accuracy", query.prior->accuracy_m}}},
            {"gravity", {down.x(), down.y(), down.z()}}};
  }

  static nlohmann::json WithFeatures(const LocalizeQuery& query, const std::string& codec,
                                     const FeatureEncoding& encoding) {
    const WireFeatures wire{query.features, codec, query.camera.width_px(),
                            query.camera.height_px()};
    nlohmann::json json = RequestJson(query);
    json["features"] = {{"data", EncodeBase64(EncodeFeatures(wire, encoding))}};
    return json;
  }

  struct Reply {
    int status;
    nlohmann::json json;
    std::string cell;  // The header X-Cairn-Cell.
  };
  static Reply PostJson(const nlohmann::json& json) {
    httplib::Client http(url());
    http.set_read_timeout(60);
    const auto result = http.Post("/v1/localize", json.dump(), "application/json");
    if (!result) {
      throw std::runtime_error(httplib::to_string(result.error()));
    }
    return {result->status, nlohmann::json::parse(result->body),
            result->get_header_value(kCellHeader)};
  }

  static std::shared_ptr<const Codebook> MapCodebook() {
    return MapStore::Open(map_path(), OpenMode::kReadOnly).Snapshot().CurrentCodebook();
  }
};

TEST_F(HttpLocalize, FeaturesThroughTheClientAgreeWithTheEngine) {
  const LocalizeQuery query = Query();
  const LocalizeResult here = LocalizeHere(query);
  const LocalizeResult there = Client().LocalizeFeatures(query);
  ExpectNearTruth(there, kQueryX);
  ExpectSamePose(here, there);
  EXPECT_EQ(there.matches.size(), here.matches.size());
  EXPECT_NEAR(there.score, here.score, 1e-9);
  EXPECT_EQ(there.counters.num_matches, here.counters.num_matches);
  EXPECT_EQ(there.tiles, here.tiles);
  EXPECT_LT((there.covariance - here.covariance).cwiseAbs().maxCoeff(), 1e-9);
}

TEST_F(HttpLocalize, UncertainCamerasThroughTheClientAgreeWithTheEngine) {
  LocalizeQuery uncertain = Query(), unknown = Query();
  uncertain.camera = WithFocalScaled(uncertain.camera, 1.05);
  uncertain.focal = FocalPrior{.log_sigma = 0.1};
  unknown.camera = CameraOfUnknownFocal(unknown.camera.width_px(), unknown.camera.height_px());
  unknown.focal = FocalPrior{.with_distortion = true};
  for (const LocalizeQuery& query : {uncertain, unknown}) {
    const LocalizeResult here = LocalizeHere(query);
    const LocalizeResult there = Client().LocalizeFeatures(query);
    ExpectNearTruth(there, kQueryX);
    ExpectSamePose(here, there);
    ASSERT_TRUE(here.camera && there.camera);
    EXPECT_NEAR(there.camera->camera.focal_px(), here.camera->camera.focal_px(), 1e-6);
    EXPECT_NEAR(there.camera->camera.focal_px(), Query().camera.focal_px(), 10.0);
    EXPECT_NEAR(there.camera->focal_sigma_px, here.camera->focal_sigma_px, 1e-6);
    EXPECT_EQ(there.camera->assumed_focal_px, query.camera.focal_px());
  }
}

TEST_F(HttpLocalize, ARigThroughTheClientAgreesWithTheEngine) {
  const LocalizeQuery query = RigQuery();
  const LocalizeResult here = LocalizeHere(query);
  const LocalizeResult there = Client().LocalizeFeatures(query);
  ASSERT_TRUE(here.localized);
  ExpectSamePose(here, there);
  EXPECT_EQ(there.counters.num_keypoints, query.num_features());
  ASSERT_EQ(there.matches.size(), here.matches.size());
  for (size_t i = 0; i < here.matches.size(); ++i) {
    EXPECT_EQ(there.matches[i].camera_idx, here.matches[i].camera_idx);
    EXPECT_EQ(there.matches[i].keypoint_idx, here.matches[i].keypoint_idx);
  }
}

TEST_F(HttpLocalize, AQueryWithoutPriorLearnsTheCellOfItsPose) {
  const LocalizeQuery query = Query();
  nlohmann::json request = WithFeatures(query, "sift", LosslessEncoding(query.features));
  request.erase("prior");
  const Reply reply = PostJson(request);
  ASSERT_EQ(reply.json["status"], "LOCALIZED");
  EXPECT_EQ(reply.cell, CellName(query.prior->position));
}

TEST_F(HttpLocalize, JsonWithBase64AgreesWithMultipart) {
  const LocalizeQuery query = Query();
  nlohmann::json request = WithFeatures(query, "sift", LosslessEncoding(query.features));
  request["prior"]["position"]["h"] = query.prior->position.h_m;
  const Reply reply = PostJson(request);
  ASSERT_EQ(reply.status, 200) << reply.json;
  EXPECT_EQ(reply.json["id"], "view");
  EXPECT_EQ(reply.json["status"], "LOCALIZED");
  const LocalizeResult result = Client().LocalizeFeatures(query);
  EXPECT_NEAR(reply.json["geopose"]["position"]["lat"].get<double>(), result.position.lat_deg(),
              1e-11);
  EXPECT_NEAR(reply.json["geopose"]["position"]["h"].get<double>(), result.position.h_m, 1e-6);
  EXPECT_EQ(reply.json["inlierCount"], result.matches.size());
}

TEST_F(HttpLocalize, CompactProjectedHalfFloatsLoseNextToNothing) {
  LocalizeQuery query = Query();
  const DescriptorCodec codec(MapCodebook());
  query.features.descriptors = codec.ProjectFeatures(query.features);
  query.features.space = DescriptorSpace::kProjected;
  const Reply reply =
      PostJson(WithFeatures(query, codec.codebook().CodecName(),
                            {GeometryEncoding::kCompact, DescriptorEncoding::kFloat16}));
  ASSERT_EQ(reply.status, 200) << reply.json;
  ASSERT_EQ(reply.json["status"], "LOCALIZED") << reply.json;
  const Geodetic truth = GeodeticFromEcef(TrueCamFromEcef(kQueryX).Inverse().translation);
  EXPECT_NEAR(reply.json["geopose"]["position"]["lat"].get<double>(), truth.lat_deg(), 5e-6);
  EXPECT_NEAR(reply.json["geopose"]["position"]["lon"].get<double>(), truth.lon_deg(), 5e-6);
}

TEST_F(HttpLocalize, ProjectedFeaturesThroughTheClient) {
  LocalizeQuery query = Query();
  const DescriptorCodec codec(MapCodebook());
  query.features.descriptors = codec.ProjectFeatures(query.features);
  query.features.space = DescriptorSpace::kProjected;
  query.codec = codec.codebook().CodecName();
  ExpectNearTruth(Client().LocalizeFeatures(query), kQueryX);
}

TEST_F(HttpLocalize, WorksWithoutPriorAndWithoutGravity) {
  LocalizeQuery query = Query();
  query.prior.reset();
  const LocalizeResult without_prior = Client().LocalizeFeatures(query);
  ExpectNearTruth(without_prior, kQueryX);
  EXPECT_FALSE(without_prior.counters.used_prior);
  query = Query();
  query.down_in_cam.reset();
  const LocalizeResult without_gravity = Client().LocalizeFeatures(query);
  ExpectNearTruth(without_gravity, kQueryX);
  EXPECT_FALSE(without_gravity.counters.used_gravity);
}

TEST_F(HttpLocalize, AMissIsAnAnswer) {
  LocalizeQuery query = Query();
  query.prior->position = Geodetic::FromDegrees(10.0, 10.0, 0.0);
  const LocalizeResult result = Client().LocalizeFeatures(query);
  EXPECT_FALSE(result.localized);
  EXPECT_EQ(result.reason, NotLocalizedReason::kNoCoverage);
}

TEST_F(HttpLocalize, FeaturesOfAnotherCodecAreRefusedAndTheRightOneIsNamed) {
  LocalizeQuery query = Query();
  const Reply raw = PostJson(WithFeatures(query, "orb", LosslessEncoding(query.features)));
  EXPECT_EQ(raw.status, 409);
  EXPECT_EQ(raw.json["code"], "wrong_codec");
  EXPECT_THAT(raw.json["detail"].get<std::string>(), HasSubstr("'sift'"));
  query.features.space = DescriptorSpace::kProjected;
  query.codec = "sift-128-16-77";
  try {
    Client().LocalizeFeatures(query);
    ADD_FAILURE() << "accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.code(), ErrorCode::kConflict);
    EXPECT_THAT(e.what(), HasSubstr(MapCodebook()->CodecName()));
  }
}

TEST_F(HttpLocalize, DescriptorsOfAnotherDimensionAreRefused) {
  LocalizeQuery query = Query();
  query.features.descriptors = query.features.descriptors.leftCols(64).eval();
  const Reply reply = PostJson(WithFeatures(query, "", LosslessEncoding(query.features)));
  EXPECT_EQ(reply.status, 400);
  EXPECT_EQ(reply.json["code"], "invalid_features");
  EXPECT_THAT(reply.json["detail"].get<std::string>(), HasSubstr("64"));
}

TEST_F(HttpLocalize, TooManyFeaturesAreRefused) {
  LocalizeQuery query = Query();
  query.features.keypoints.assign(5001, {1.0f, 1.0f, 1.0f, 0.0f});
  query.features.descriptors = DescriptorMatrix::Zero(5001, 128);
  const Reply reply = PostJson(
      WithFeatures(query, "sift", {GeometryEncoding::kCompact, DescriptorEncoding::kUint8}));
  EXPECT_EQ(reply.status, 413);
  EXPECT_EQ(reply.json["code"], "too_many_features");
}

TEST_F(HttpLocalize, NoFeaturesAreAMiss) {
  LocalizeQuery query = Query();
  query.features.keypoints.clear();
  query.features.descriptors.resize(0, 128);
  EXPECT_EQ(Client().LocalizeFeatures(query).reason, NotLocalizedReason::kTooFewFeatures);
}

// A binary PGM with a checkerboard.
std::vector<uint8_t> PgmImage(int width, int height) {
  const std::string head = fmt::format("P5\n{} {}\n255\n", width, height);
  std::vector<uint8_t> bytes(head.begin(), head.end());
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      bytes.push_back((x / 16 + y / 16) % 2 == 0 ? 40 : 200);
    }
  }
  return bytes;
}

// The headers of a JPEG of 60,000 x 60,000 pixels around next to no data.
std::vector<uint8_t> HugeJpeg() {
  return {0xff, 0xd8,                                                       // Start.
          0xff, 0xc0, 0, 11, 8, 0xea, 0x60, 0xea, 0x60, 1, 1, 0x11, 0,      // Frame.
          0xff, 0xda, 0, 8,  1, 1,    0,    0,    63,   0, 0, 0xff, 0xd9};  // Scan, end.
}

TEST_F(HttpLocalize, AnImageIsDecodedAndItsFeaturesAreMatched) {
  const LocalizeResult result = Client().LocalizeImages(Query(), {PgmImage(640, 480)});
  EXPECT_FALSE(result.localized);  // The street has no such facade.
  EXPECT_GT(result.counters.num_keypoints, 0);
}

TEST_F(HttpLocalize, ImagesOfARigHaveTheFeaturesThatEachHasAlone) {
  const LocalizeQuery one = Query();
  LocalizeQuery rig = one;
  rig.other_cameras.assign(2, {.camera = one.camera, .cam_from_first = {}, .features = {}});
  const std::vector<uint8_t> image = PgmImage(640, 480);
  const int num_of_one = Client().LocalizeImages(one, {image}).counters.num_keypoints;
  ASSERT_GT(num_of_one, 0);
  EXPECT_EQ(Client().LocalizeImages(rig, {image, image, image}).counters.num_keypoints,
            3 * num_of_one);
  EXPECT_THROW(Client().LocalizeImages(rig, {image, image}), Error);
  EXPECT_THROW(Client().LocalizeImages(rig, {image, image, {}}), Error);
  EXPECT_THROW(Client().LocalizeImages(rig, {image, image, PgmImage(320, 240)}), Error);
}

// Images and features wait in one line: neither keeps the other from its turn.
TEST_F(HttpLocalize, MoreImagesThanCoresAndFeaturesAreAllAnswered) {
  const int num_threads = 2 * std::max(2u, std::thread::hardware_concurrency());
  const std::vector<uint8_t> image = PgmImage(640, 480);
  std::vector<LocalizeResult> of_images(num_threads), of_features(num_threads);
  std::vector<std::thread> threads;
  for (int i = 0; i < num_threads; ++i) {
    threads.emplace_back([&, i] { of_images[i] = Client().LocalizeImages(Query(), {image}); });
    threads.emplace_back([&, i] { of_features[i] = Client().LocalizeFeatures(Query()); });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  for (int i = 0; i < num_threads; ++i) {
    EXPECT_GT(of_images[i].counters.num_keypoints, 0);
    EXPECT_NE(of_images[i].reason, NotLocalizedReason::kTimeout);
    EXPECT_TRUE(of_features[i].localized);
  }
}

TEST_F(HttpLocalize, RawPixelsAreAcceptedByName) {
  nlohmann::json request = RequestJson(Query());
  for (const auto& [format, bytes_a_pixel] : {std::pair("GRAY8", 1), std::pair("RGBA32", 4)}) {
    request["image"] = {
        {"format", format},
        {"data", EncodeBase64(std::vector<uint8_t>(size_t{640} * 480 * bytes_a_pixel, 128))}};
    const Reply reply = PostJson(request);
    EXPECT_EQ(reply.status, 200) << reply.json;
    EXPECT_EQ(reply.json["reason"], "TOO_FEW_FEATURES");
    EXPECT_TRUE(reply.json["stages"].contains("extraction"));
  }
}

TEST_F(HttpLocalize, ImagesThatCannotBeUsedAreRefused) {
  const struct {
    const char* name;
    std::vector<uint8_t> bytes;
    int status;
    const char* code;
  } cases[] = {
      {"text", {'h', 'e', 'l', 'l', 'o'}, 400, "invalid_image"},
      {"cut JPEG", {0xff, 0xd8, 0xff, 0xe0, 0, 16, 'J', 'F', 'I', 'F'}, 400, "invalid_image"},
      {"other size", PgmImage(320, 240), 400, "invalid_image"},
      {"huge", HugeJpeg(), 413, "image_too_large"},
  };
  nlohmann::json request = RequestJson(Query());
  for (const auto& bad : cases) {
    request["image"] = {{"data", EncodeBase64(bad.bytes)}};
    const Reply reply = PostJson(request);
    EXPECT_EQ(reply.status, bad.status) << bad.name;
    EXPECT_EQ(reply.json["code"], bad.code) << bad.name;
  }
}

// What a map of features can tell: the pose, asked for in the two media types.
TEST_F(HttpLocalize, AnOgcGeoPoseIsGivenToWhoAsksForIt) {
  const LocalizeQuery query = Query();
  const auto post = [&](const LocalizeQuery& asked, const char* accept) {
    httplib::Client http(url());
    http.set_read_timeout(60);
    auto result = http.Post("/v1/localize", {{"Accept", accept}},
                            WithFeatures(asked, "", LosslessEncoding(asked.features)).dump(),
                            "application/json");
    if (!result) {
      throw std::runtime_error(httplib::to_string(result.error()));
    }
    return *result;
  };
  const httplib::Response full = post(query, "application/json");
  const httplib::Response pose = post(query, "application/geopose+json");
  EXPECT_EQ(pose.status, 200);
  EXPECT_EQ(pose.get_header_value("Content-Type"), "application/geopose+json");
  EXPECT_EQ(nlohmann::json::parse(pose.body), nlohmann::json::parse(full.body)["geopose"]);
  LocalizeQuery elsewhere = query;
  elsewhere.prior->position = Geodetic::FromDegrees(10.0, 10.0, 0.0);
  const httplib::Response miss = post(elsewhere, "application/geopose+json");
  EXPECT_EQ(miss.status, 404);
  EXPECT_EQ(nlohmann::json::parse(miss.body)["code"], "not_localized");
}

// The largest picture that is promised is no larger than the largest request.
TEST_F(HttpLocalize, TwelveMegapixelsFitIntoARequest) {
  nlohmann::json request = RequestJson(Query());
  request["camera"] = {
      {"model", "SIMPLE_PINHOLE"}, {"size", {4032, 3024}}, {"modelParams", {3000, 2016, 1512}}};
  request["image"] = {{"format", "GRAY8"},
                      {"data", EncodeBase64(std::vector<uint8_t>(size_t{4032} * 3024, 90))}};
  const Reply reply = PostJson(request);
  EXPECT_EQ(reply.status, 200) << reply.json;
  EXPECT_EQ(reply.json["reason"], "TOO_FEW_FEATURES");
  request["camera"]["size"] = {4033, 3024};
  EXPECT_EQ(PostJson(request).status, 400);
}

TEST_F(HttpLocalize, AGeoPoseMissIsAProblemWithTheReason) {
  httplib::Client http(url());
  http.set_read_timeout(60);
  const nlohmann::json request = {
      {"type", "geopose"},
      {"sensorReadings",
       {{"cameraReadings",
         {{{"size", {640, 480}},
           {"imageFormat", "GRAY8"},
           {"imageBytes", EncodeBase64(std::vector<uint8_t>(640 * 480, 9))},
           {"params", {{"model", "PINHOLE"}, {"modelParams", {500, 500, 320, 240}}}}}}}}}};
  const auto result = http.Post("/geopose", {{"Accept", "application/vnd.oscp+json;version=2.0;"}},
                                request.dump(), "application/json");
  ASSERT_TRUE(result);
  EXPECT_EQ(result->status, 404);
  const auto problem = nlohmann::json::parse(result->body);
  EXPECT_EQ(problem["code"], "not_localized");
  EXPECT_THAT(problem["detail"].get<std::string>(), HasSubstr("TOO_FEW_FEATURES"));
}

TEST_F(HttpLocalize, EightThreadsGetTheSameAnswer) {
  const LocalizeQuery query = Query();
  const LocalizeResult expected = Client().LocalizeFeatures(query);
  std::vector<LocalizeResult> results(16);
  std::vector<std::thread> threads;
  for (int t = 0; t < 8; ++t) {
    threads.emplace_back([&, t] {
      LocalizeClient client = Client();
      for (int i = 0; i < 2; ++i) {
        results[2 * t + i] = client.LocalizeFeatures(query);
      }
    });
  }
  for (std::thread& thread : threads) {
    thread.join();
  }
  for (const LocalizeResult& result : results) {
    ExpectSamePose(result, expected);
  }
}

TEST_F(HttpLocalize, QueriesSeeAnUpdateAsSoonAsItIsPublished) {
  LocalizeQuery query = Query();
  query.prior.reset();
  const LocalizeResult before = Client().LocalizeFeatures(query);
  testing::StreetWorldOptions far_away;
  far_away.origin = Geodetic::FromDegrees(47.40, 8.60, 400.0);
  far_away.seed = 5;
  testing::IngestStreet(testing::StreetWorld(far_away), "second", map_path());
  const LocalizeResult after = Client().LocalizeFeatures(query);
  EXPECT_EQ(Value(after.map_version), Value(before.map_version) + 1);
  EXPECT_GT(after.counters.num_tiles_found, before.counters.num_tiles_found);
}

}  // namespace
}  // namespace cairn
