#include "http/json/localize_response.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/error.h"

namespace cairn {
namespace {

// Counters that differ from each other, and every other flag.
StageCounters SomeCounters() {
  return {.num_keypoints = 1,
          .num_tiles_found = 4,
          .num_tiles_searched = 3,
          .num_tiles_loaded = 5,
          .num_places_searched = 2,
          .num_descriptors = 6,
          .num_distances = 7,
          .num_matches = 8,
          .num_matched_keypoints = 9,
          .num_votes = 12345,
          .num_candidates = 10,
          .num_ransac_iterations = 11,
          .num_refined_keyframes = 12,
          .num_rematches = 13,
          .used_prior = false,
          .used_gravity = true,
          .tile_limit_hit = true,
          .tiles_cut_short = false,
          .matching_cut_short = true,
          .pose_cut_short = false,
          .refinement_cut_short = true};
}

// The structured binding names every member, so that a new one does not compile until it is
// compared here.
void ExpectEqual(const StageCounters& a, const StageCounters& b) {
  const auto& [num_keypoints, num_tiles_found, num_tiles_searched, num_tiles_loaded,
               num_places_searched, num_descriptors, num_distances, num_matches,
               num_matched_keypoints, num_votes, num_candidates, num_ransac_iterations,
               num_refined_keyframes, num_rematches, used_prior, used_gravity, tile_limit_hit,
               tiles_cut_short, matching_cut_short, pose_cut_short, refinement_cut_short] = a;
  EXPECT_EQ(num_keypoints, b.num_keypoints);
  EXPECT_EQ(num_tiles_found, b.num_tiles_found);
  EXPECT_EQ(num_tiles_searched, b.num_tiles_searched);
  EXPECT_EQ(num_tiles_loaded, b.num_tiles_loaded);
  EXPECT_EQ(num_places_searched, b.num_places_searched);
  EXPECT_EQ(num_descriptors, b.num_descriptors);
  EXPECT_EQ(num_distances, b.num_distances);
  EXPECT_EQ(num_matches, b.num_matches);
  EXPECT_EQ(num_matched_keypoints, b.num_matched_keypoints);
  EXPECT_EQ(num_votes, b.num_votes);
  EXPECT_EQ(num_candidates, b.num_candidates);
  EXPECT_EQ(num_ransac_iterations, b.num_ransac_iterations);
  EXPECT_EQ(num_refined_keyframes, b.num_refined_keyframes);
  EXPECT_EQ(num_rematches, b.num_rematches);
  EXPECT_EQ(used_prior, b.used_prior);
  EXPECT_EQ(used_gravity, b.used_gravity);
  EXPECT_EQ(tile_limit_hit, b.tile_limit_hit);
  EXPECT_EQ(tiles_cut_short, b.tiles_cut_short);
  EXPECT_EQ(matching_cut_short, b.matching_cut_short);
  EXPECT_EQ(pose_cut_short, b.pose_cut_short);
  EXPECT_EQ(refinement_cut_short, b.refinement_cut_short);
}

LocalizeResult SomeResult() {
  LocalizeResult result;
  result.localized = true;
  result.anchor = Geodetic::FromDegrees(47.3769, 8.5417, 0.0);
  result.cam_from_anchor =
      Rigid3d(ExpSo3({0.3, -1.2, 0.7}), Eigen::Vector3d(120.0, -40.0, 12.0)).Inverse();
  result.cam_from_ecef = result.cam_from_anchor * EcefFromEnu(result.anchor).Inverse();
  result.position = GeodeticFromEcef(result.cam_from_ecef.Inverse().translation);
  const Eigen::Matrix<double, 6, 6> root = Eigen::Matrix<double, 6, 6>::Random();
  result.covariance = root * root.transpose();
  result.position_accuracy_m = 0.31;
  result.rotation_accuracy_rad = 0.015;
  result.map_accuracy_m = 0.4;
  result.map_accuracy_rad = 0.002;
  result.score = 88.5;
  result.confidence = 0.97;
  result.false_alarm_rate = 1e-9;
  result.prior_disagrees = true;
  for (int i = 0; i < 10; ++i) {
    result.matches.push_back({.keypoint_idx = 3 * i,
                              .camera_idx = i % 4,
                              .pixel = {10.5 * i, 20.25},
                              .landmark_id = LandmarkId(1000 + i),
                              .tile_idx = i % 2,
                              .x_in_anchor = {1.0 * i, 2.0, 3.0},
                              .sigma_m = 0.125,
                              .right_probability = 0.25 * i,
                              .traits = {.error_px = 0.5 * i}});
  }
  result.map_version = MapVersion(42);
  result.map_is_stale = true;
  result.tiles = {TileId::Parse("32N-03104-35120"), TileId::Containing(result.anchor)};
  result.counters = SomeCounters();
  result.times.seconds[static_cast<int>(Stage::kPose)] = 0.00125;
  result.times.total_seconds = 0.02;
  return result;
}

LocalizeRequest SomeRequest() {
  LocalizeRequest request;
  request.query.id = "q1";
  request.timestamp_ms = 5;
  request.answer.with_matches = true;
  return request;
}

TEST(LocalizeResponse, RoundTripsThroughTheWire) {
  const LocalizeResult in = SomeResult();
  for (const InnerFrame frame : {InnerFrame::kFlu, InnerFrame::kRdf, InnerFrame::kRub}) {
    LocalizeRequest request = SomeRequest();
    request.answer.inner_frame = frame;
    const LocalizeResult out = ParseLocalizeResponse(LocalizeResponseJson(in, request, {}));
    EXPECT_TRUE(out.localized);
    EXPECT_LT(RotationAngleRad(out.cam_from_ecef.rotation, in.cam_from_ecef.rotation), 1e-9);
    EXPECT_LT((out.cam_from_anchor.Inverse().translation - in.cam_from_anchor.Inverse().translation)
                  .norm(),
              1e-6);
    EXPECT_LT((out.covariance - in.covariance).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_NEAR(out.rotation_accuracy_rad, in.rotation_accuracy_rad, 1e-12);
    EXPECT_EQ(out.position_accuracy_m, in.position_accuracy_m);
    EXPECT_NEAR(out.map_accuracy_m, in.map_accuracy_m, 1e-12);
    EXPECT_NEAR(out.map_accuracy_rad, in.map_accuracy_rad, 1e-12);
    EXPECT_EQ(out.score, in.score);
    EXPECT_EQ(out.confidence, in.confidence);
    EXPECT_EQ(out.false_alarm_rate, in.false_alarm_rate);
    EXPECT_EQ(out.prior_disagrees, in.prior_disagrees);
    EXPECT_EQ(out.map_version, in.map_version);
    EXPECT_TRUE(out.map_is_stale);
    EXPECT_LT((EcefFromGeodetic(out.position) - EcefFromGeodetic(in.position)).norm(), 1e-6);
    EXPECT_LT((EcefFromGeodetic(out.anchor) - EcefFromGeodetic(in.anchor)).norm(), 1e-6);
    EXPECT_EQ(out.tiles, in.tiles);
    ExpectEqual(in.counters, out.counters);
    EXPECT_NEAR(out.times.seconds[static_cast<int>(Stage::kPose)], 0.00125, 1e-12);
    EXPECT_NEAR(out.times.total_seconds, in.times.total_seconds, 1e-12);
    ASSERT_EQ(out.matches.size(), in.matches.size());
    EXPECT_EQ(out.matches[3].keypoint_idx, 9);
    EXPECT_EQ(out.matches[3].pixel, in.matches[3].pixel);
    EXPECT_EQ(out.matches[3].landmark_id, in.matches[3].landmark_id);
    EXPECT_EQ(out.matches[3].x_in_anchor, in.matches[3].x_in_anchor);
    EXPECT_EQ(out.matches[3].tile_idx, 1);
    EXPECT_EQ(out.matches[3].sigma_m, in.matches[3].sigma_m);
    EXPECT_EQ(out.matches[3].right_probability, in.matches[3].right_probability);
    EXPECT_EQ(out.matches[3].traits.error_px, in.matches[3].traits.error_px);
    EXPECT_EQ(out.matches[3].camera_idx, 3);
  }
}

TEST(LocalizeResponse, RoundTripsAnEstimatedCamera) {
  LocalizeResult in = SomeResult();
  EXPECT_FALSE(ParseLocalizeResponse(LocalizeResponseJson(in, SomeRequest(), {})).camera);
  in.camera = CameraEstimate{
      .camera = Camera(CameraModel::kSimpleRadial, 640, 480, {501.5, 320, 240, -0.05}),
      .focal_sigma_px = 2.5,
      .assumed_focal_px = 544,
      .assumed_focal_sigma_px = 190.4,
      .focal_disagrees = true};
  const LocalizeResult out = ParseLocalizeResponse(LocalizeResponseJson(in, SomeRequest(), {}));
  ASSERT_TRUE(out.camera);
  EXPECT_EQ(out.camera->camera.model(), CameraModel::kSimpleRadial);
  EXPECT_EQ(out.camera->camera.params(), in.camera->camera.params());
  EXPECT_EQ(out.camera->focal_sigma_px, 2.5);
  EXPECT_EQ(out.camera->assumed_focal_px, 544);
  EXPECT_EQ(out.camera->assumed_focal_sigma_px, 190.4);
  EXPECT_TRUE(out.camera->focal_disagrees);
}

TEST(LocalizeResponse, GeoPoseHasNothingButPositionAndQuaternion) {
  const auto json = nlohmann::json::parse(LocalizeResponseJson(SomeResult(), SomeRequest(), {}));
  EXPECT_EQ(json["geopose"].size(), 2u);
  EXPECT_EQ(json["geopose"]["position"].size(), 3u);
  EXPECT_EQ(json["geopose"]["quaternion"].size(), 4u);
  EXPECT_EQ(json["id"], "q1");
  EXPECT_EQ(json["timestamp"], 5);
  EXPECT_TRUE(json["reason"].is_null());
  EXPECT_EQ(json["inlierCount"], 10);
}

TEST(LocalizeResponse, CovarianceHasTheTranslationFirst) {
  LocalizeResult result = SomeResult();
  result.anchor = result.position;  // The same axes on both sides.
  result.covariance.setZero();
  result.covariance.diagonal() << 1, 2, 3, 4, 5, 6;  // Rotation, translation.
  const auto json = nlohmann::json::parse(LocalizeResponseJson(result, SomeRequest(), {}));
  const double expected[] = {4, 5, 6, 1, 2, 3};
  for (int i = 0; i < 6; ++i) {
    EXPECT_NEAR(json["covariance"][7 * i].get<double>(), expected[i], 1e-9);
  }
}

TEST(LocalizeResponse, SaysHowAccurateThePoseIsInTheMapAndOnEarth) {
  auto json = nlohmann::json::parse(LocalizeResponseJson(SomeResult(), SomeRequest(), {}));
  EXPECT_EQ(json["accuracy"]["position"], 0.31);
  EXPECT_NEAR(json["accuracyOnEarth"]["position"].get<double>(), std::hypot(0.31, 0.4), 1e-12);
  // An answer of a server that knows nothing of it.
  json.erase("accuracyOnEarth");
  const LocalizeResult out = ParseLocalizeResponse(json.dump());
  EXPECT_EQ(out.position_accuracy_m, 0.31);
  EXPECT_EQ(out.map_accuracy_m, 0.0);
}

TEST(LocalizeResponse, ThinsMatchesEvenly) {
  LocalizeRequest request = SomeRequest();
  request.answer.max_matches = 5;
  const auto json = nlohmann::json::parse(LocalizeResponseJson(SomeResult(), request, {}));
  ASSERT_EQ(json["matches"].size(), 5u);
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(json["matches"][i]["keypoint"], 6 * i);
  }
  EXPECT_EQ(json["inlierCount"], 10);
}

TEST(LocalizeResponse, LeavesOutWhatWasNotAskedFor) {
  LocalizeRequest request = SomeRequest();
  request.answer.with_matches = request.answer.with_timings = request.answer.with_covariance =
      false;
  const auto json = nlohmann::json::parse(LocalizeResponseJson(SomeResult(), request, {}));
  EXPECT_FALSE(json.contains("matches"));
  EXPECT_FALSE(json.contains("covariance"));
  EXPECT_FALSE(json["stages"]["pose"].contains("ms"));
  EXPECT_TRUE(json["stages"]["pose"].contains("iterations"));
}

TEST(LocalizeResponse, AMissHasAReasonAndNoPose) {
  LocalizeResult result = SomeResult();
  result.localized = false;
  result.reason = NotLocalizedReason::kTooFewMatches;
  result.reason_text = "the map knows too little of the photo";
  const std::string text = LocalizeResponseJson(result, SomeRequest(), {});
  const auto json = nlohmann::json::parse(text);
  EXPECT_EQ(json["status"], "NOT_LOCALIZED");
  EXPECT_EQ(json["reason"], "TOO_FEW_MATCHES");
  EXPECT_FALSE(json.contains("geopose"));
  const LocalizeResult out = ParseLocalizeResponse(text);
  EXPECT_FALSE(out.localized);
  EXPECT_EQ(out.reason, NotLocalizedReason::kTooFewMatches);
  EXPECT_EQ(out.reason_text, result.reason_text);
}

TEST(LocalizeResponse, ClientRefusesWhatIsNoAnswer) {
  for (const char* text : {"", "[]", "{}", R"({"status":"LOCALIZED"})", "<html>"}) {
    EXPECT_THROW(ParseLocalizeResponse(text), Error) << text;
  }
}

}  // namespace
}  // namespace cairn
