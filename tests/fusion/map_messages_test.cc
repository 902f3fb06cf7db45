#include "fusion/transport/map_messages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/cell_name.h"
#include "core/error.h"
#include "core/tile_id.h"
#include "core/wire/multipart.h"
#include "core/wire/wire_response.h"
#include "http/json/localize_request.h"

namespace cairn::fusion {
namespace {

using Json = nlohmann::json;

constexpr int kMaxMatches = 300;
const Geodetic kOrigin = Geodetic::FromDegrees(47.3769, 8.5417, 408.0);

MapQuery QueryOf(int num_features) {
  MapQuery query;
  query.request.query_id = 17;
  query.request.down_in_cam = {0.0, 1.0, 0.0};
  query.camera = Camera(CameraModel::kPinhole, 640, 480, {460.0, 460.0, 320.0, 240.0});
  query.features.space = DescriptorSpace::kProjected;
  query.codec = "sift-128-16-1";
  query.features.descriptors = DescriptorMatrix::Random(num_features, 16);
  for (int i = 0; i < num_features; ++i) {
    query.features.keypoints.push_back({static_cast<float>(i % 640), 100.0f, 2.0f, 0.5f});
  }
  return query;
}

Json RequestOf(const MapQuery& query) {
  const MapRequest request = MakeMapRequest(query, kOrigin, 2000, 300);
  const std::vector<MultipartPart> parts = ParseMultipart(request.content_type, request.body);
  EXPECT_EQ(parts.at(0).name, "request");
  EXPECT_EQ(parts.at(1).name, "features");
  return Json::parse(parts.at(0).content);
}

// What a server answers: a camera 2 m east of the origin, level, that looks north.
WireResponse Response() {
  const Geodetic position = GeodeticFromEcef(EcefFromEnu(kOrigin) * Eigen::Vector3d(2.0, 0.0, 0.0));
  const double half = std::sqrt(0.5);
  const GeoPose geopose{position, Eigen::Quaterniond(half, -half, 0.0, 0.0)};
  return {.pose = WirePose{.geopose = geopose, .inner_frame = InnerFrame::kRdf, .anchor = position},
          .matches = {{WireMatch{.pixel = {10.5, 20.5},
                                 .landmark_id = 5,
                                 .x_in_anchor = {1.0, 7.0, 3.0},
                                 .sigma_m = 0.04,
                                 .keypoint_idx = 1}}},
          .map_version = 1,
          .tiles = {TileId::Parse("32N-03104-35120")}};
}

Json AnswerJson() { return WireResponseJson(Response()); }

TEST(MapMessages, TheCellIsThatOfThePrior) {
  MapQuery query = QueryOf(1);
  query.request.prior.reset();
  query.rough_position.reset();
  EXPECT_EQ(MakeMapRequest(query, kOrigin, 2000, 300).cell, "");
  const Geodetic rough = Geodetic::FromDegrees(-40.0, 100.0, 0.0);
  query.rough_position.emplace(RoughPosition{.position = rough});
  EXPECT_EQ(MakeMapRequest(query, kOrigin, 2000, 300).cell, CellName(rough));
  query.request.prior.emplace();  // At the origin of `global`.
  EXPECT_EQ(MakeMapRequest(query, kOrigin, 2000, 300).cell, CellName(kOrigin));
}

TEST(MapMessages, FiveHundredProjectedFeaturesTakeSome20Kilobytes) {
  const MapRequest request = MakeMapRequest(QueryOf(500), kOrigin, 2000, 300);
  EXPECT_LT(request.body.size(), 20'500u);
  EXPECT_GT(request.body.size(), 19'000u);
}

TEST(MapMessages, RequestSaysWhatTheFilterKnows) {
  MapQuery query = QueryOf(3);
  PosePrior prior;
  prior.global_from_cam = Rigid3d(Eigen::Quaterniond::Identity(), Eigen::Vector3d(30.0, 40.0, 2.0));
  prior.covariance = Matrix6d::Identity() * 4.0;
  query.request.prior = prior;
  query.rough_position = RoughPosition{Geodetic::FromDegrees(1.0, 2.0, 3.0), 15.0};
  const Json json = RequestOf(query);
  EXPECT_EQ(json["id"], "17");
  EXPECT_EQ(json["gravity"], Json({0.0, 1.0, 0.0}));
  EXPECT_EQ(json["camera"]["modelParams"].size(), 4u);
  EXPECT_EQ(json["options"]["innerFrame"], "RDF");
  EXPECT_NEAR(json["prior"]["accuracy"].get<double>(), 1.51 * 2.0, 1e-3);
  const Json& position = json["prior"]["position"];
  const Geodetic place = Geodetic::FromDegrees(position["lat"], position["lon"], position["h"]);
  const Eigen::Vector3d x_in_global = EcefFromEnu(kOrigin).Inverse() * EcefFromGeodetic(place);
  EXPECT_LT((x_in_global - prior.global_from_cam.translation).norm(), 1e-6);
}

TEST(MapMessages, TheServerReadsTheRequestAsItIsMeant) {
  MapQuery query = QueryOf(3);
  PosePrior prior;
  prior.covariance = Matrix6d::Identity() * 4.0;
  query.request.prior = prior;
  const MapRequest sent = MakeMapRequest(query, kOrigin, 1234, 77);
  const LocalizeRequest read = ParseLocalizeRequest(sent.content_type, sent.body, {});
  EXPECT_EQ(read.query.id, "17");
  EXPECT_EQ(read.query.camera.model(), query.camera.model());
  EXPECT_EQ(read.query.camera.width_px(), 640);
  EXPECT_EQ(read.query.camera.height_px(), 480);
  EXPECT_EQ(read.query.camera.params(), query.camera.params());
  EXPECT_FALSE(read.query.focal);
  EXPECT_EQ(read.query.codec, query.codec);
  EXPECT_EQ(read.query.features.size(), 3);
  ASSERT_TRUE(read.query.prior);
  EXPECT_NEAR(read.query.prior->position.lat_rad, kOrigin.lat_rad, 1e-12);
  EXPECT_NEAR(read.query.prior->position.lon_rad, kOrigin.lon_rad, 1e-12);
  EXPECT_NEAR(read.query.prior->position.h_m, kOrigin.h_m, 1e-6);
  EXPECT_NEAR(read.query.prior->accuracy_m, 1.51 * 2.0, 1e-3);
  EXPECT_EQ(read.query.prior->height_sigma_m, 2.0);
  EXPECT_EQ(read.query.down_in_cam, query.request.down_in_cam);
  EXPECT_EQ(read.timeout_ms, 1234);
  EXPECT_EQ(read.answer.inner_frame, InnerFrame::kRdf);
  EXPECT_EQ(read.answer.max_matches, 77);
  EXPECT_TRUE(read.answer.with_matches);
  EXPECT_FALSE(read.answer.with_timings);
  EXPECT_FALSE(read.answer.with_covariance);
}

TEST(MapMessages, RoughPositionServesUntilThereIsAPrior) {
  MapQuery query = QueryOf(3);
  EXPECT_FALSE(RequestOf(query).contains("prior"));
  query.rough_position = RoughPosition{Geodetic::FromDegrees(47.0, 8.0, 3.0), 12.0};
  EXPECT_EQ(RequestOf(query)["prior"]["accuracy"], 12.0);
}

TEST(MapMessages, FeaturesOutsideTheImageAreRefused) {
  MapQuery query = QueryOf(3);
  query.features.keypoints[1].x_px = 1000.0f;
  EXPECT_THROW(MakeMapRequest(query, kOrigin, 2000, 300), Error);
}

TEST(MapMessages, AnswersAreMovedToGlobal) {
  MapQuery query = QueryOf(3);
  query.track_of_keypoint = {std::nullopt, 77, std::nullopt};
  const auto answer = ReadMapAnswer(AnswerJson().dump(), query, kOrigin, kMaxMatches);
  ASSERT_TRUE(answer);
  EXPECT_TRUE(answer->localized);
  EXPECT_EQ(answer->query_id, 17);
  EXPECT_LT((answer->global_from_cam.translation - Eigen::Vector3d(2.0, 0.0, 0.0)).norm(), 1e-6);
  const Eigen::Vector3d ahead = answer->global_from_cam.rotation * Eigen::Vector3d::UnitZ();
  EXPECT_LT((ahead - Eigen::Vector3d::UnitY()).norm(), 1e-5);
  ASSERT_EQ(answer->matches.size(), 1u);
  const MapMatch& match = answer->matches[0];
  EXPECT_LT((match.x_in_global - Eigen::Vector3d(3.0, 7.0, 3.0)).norm(), 1e-4);
  EXPECT_EQ(match.pixel, Eigen::Vector2d(10.5, 20.5));
  EXPECT_EQ(match.track_id, 77u);
  EXPECT_EQ(match.sigma_m, 0.04);
  EXPECT_EQ(match.landmark_id, 5u);
  EXPECT_EQ(match.tile_id, TileId::Parse("32N-03104-35120").value());
}

TEST(MapMessages, NoMoreMatchesAreTakenThanWereAskedFor) {
  Json json = AnswerJson();
  const Json match = json["matches"][0];
  for (int i = 0; i < 1000; ++i) {
    json["matches"].push_back(match);
  }
  const auto answer = ReadMapAnswer(json.dump(), QueryOf(3), kOrigin, kMaxMatches);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->matches.size(), static_cast<size_t>(kMaxMatches));
}

TEST(MapMessages, AnAnswerNeedsOnlyWhatPlacesItsMatches) {
  Json json = AnswerJson();
  for (const char* name :
       {"id", "prior", "confidence", "score", "falseAlarmRate", "priorDisagrees", "inlierCount"}) {
    ASSERT_EQ(json.erase(name), 1u) << name;
  }
  json["map"].erase("version");
  json["matches"][0].erase("error");
  json["matches"][0].erase("probability");
  const auto answer = ReadMapAnswer(json.dump(), QueryOf(3), kOrigin, kMaxMatches);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->matches.size(), 1u);
  for (const char* name : {"status", "geopose", "innerFrame", "anchor", "matches"}) {
    Json incomplete = json;
    ASSERT_EQ(incomplete.erase(name), 1u) << name;
    EXPECT_FALSE(ReadMapAnswer(incomplete.dump(), QueryOf(3), kOrigin, kMaxMatches)) << name;
  }
}

TEST(MapMessages, NoPoseIsAnAnswer) {
  const Json json = WireResponseJson({.reason = "NO_COVERAGE"});
  const auto answer = ReadMapAnswer(json.dump(), QueryOf(1), kOrigin, kMaxMatches);
  ASSERT_TRUE(answer);
  EXPECT_FALSE(answer->localized);
  EXPECT_EQ(answer->query_id, 17);
}

TEST(MapMessages, AnswersInAnotherFrameOrWithoutMatchesAreNone) {
  ASSERT_TRUE(ReadMapAnswer(AnswerJson().dump(), QueryOf(3), kOrigin, kMaxMatches));
  WireResponse response = Response();
  response.pose->inner_frame = InnerFrame::kFlu;
  EXPECT_FALSE(ReadMapAnswer(WireResponseJson(response).dump(), QueryOf(3), kOrigin, kMaxMatches));
  response = Response();
  response.matches.reset();
  EXPECT_FALSE(ReadMapAnswer(WireResponseJson(response).dump(), QueryOf(3), kOrigin, kMaxMatches));
}

TEST(MapMessages, MembersThatAreMissingOrWrongMakeNoAnswer) {
  const MapQuery query = QueryOf(3);
  ASSERT_TRUE(ReadMapAnswer(AnswerJson().dump(), query, kOrigin, kMaxMatches));
  for (const char* member : {"status", "innerFrame", "geopose", "anchor", "map", "matches"}) {
    Json json = AnswerJson();
    json.erase(member);
    EXPECT_FALSE(ReadMapAnswer(json.dump(), query, kOrigin, kMaxMatches)) << "without " << member;
    json[member] = "nonsense";
    EXPECT_FALSE(ReadMapAnswer(json.dump(), query, kOrigin, kMaxMatches) &&
                 ReadMapAnswer(json.dump(), query, kOrigin, kMaxMatches)->localized)
        << member;
  }
  for (const char* member : {"u", "enu", "sigma", "keypoint", "tile"}) {
    Json json = AnswerJson();
    json["matches"][0].erase(member);
    EXPECT_FALSE(ReadMapAnswer(json.dump(), query, kOrigin, kMaxMatches)) << "without " << member;
  }
}

TEST(MapMessages, NumbersWithoutSenseMakeNoAnswer) {
  const MapQuery query = QueryOf(3);
  Json json = AnswerJson();
  json["matches"][0]["sigma"] = -1.0;
  EXPECT_FALSE(ReadMapAnswer(json.dump(), query, kOrigin, kMaxMatches));
  json = AnswerJson();
  json["matches"][0]["tile"] = 9;
  EXPECT_FALSE(ReadMapAnswer(json.dump(), query, kOrigin, kMaxMatches));
  json = AnswerJson();
  json["geopose"]["quaternion"]["w"] = 0.2;
  EXPECT_FALSE(ReadMapAnswer(json.dump(), query, kOrigin, kMaxMatches));
  json = AnswerJson();
  json["geopose"]["position"]["lat"] = 500.0;
  EXPECT_FALSE(ReadMapAnswer(json.dump(), query, kOrigin, kMaxMatches));
  json = AnswerJson();
  json["matches"][0]["u"] = std::numeric_limits<double>::infinity();  // Dumps as null.
  EXPECT_FALSE(ReadMapAnswer(json.dump(), query, kOrigin, kMaxMatches));
}

TEST(MapMessages, AMemberThatIsThereTwiceMakesNoAnswer) {
  EXPECT_FALSE(ReadMapAnswer(R"({"status":"NOT_LOCALIZED","status":"NOT_LOCALIZED"})", QueryOf(3),
                             kOrigin, kMaxMatches));
}

TEST(MapMessages, EveryTruncationIsRefused) {
  const std::string whole = AnswerJson().dump();
  for (size_t length = 0; length < whole.size(); ++length) {
    EXPECT_FALSE(
        ReadMapAnswer(std::string_view(whole).substr(0, length), QueryOf(3), kOrigin, kMaxMatches))
        << length;
  }
}

}  // namespace
}  // namespace cairn::fusion
