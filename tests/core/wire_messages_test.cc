// The messages of POST /v1/localize: what one side writes, the other reads. The structured bindings
// name every member, so that a new member does not compile until it is compared here.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "core/file_bytes.h"
#include "core/wire/json_error.h"
#include "core/wire/wire_request.h"
#include "core/wire/wire_response.h"

namespace cairn {
namespace {

void ExpectEqual(const Camera& a, const Camera& b) {
  EXPECT_EQ(a.model(), b.model());
  EXPECT_EQ(a.width_px(), b.width_px());
  EXPECT_EQ(a.height_px(), b.height_px());
  EXPECT_EQ(a.params(), b.params());
}

void ExpectEqual(const Geodetic& a, const Geodetic& b) {
  EXPECT_NEAR(a.lat_rad, b.lat_rad, 1e-15);
  EXPECT_NEAR(a.lon_rad, b.lon_rad, 1e-15);
  EXPECT_EQ(a.h_m, b.h_m);
}

void ExpectEqual(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  EXPECT_LT((a.coeffs() - b.coeffs()).norm(), 1e-15);
}

void ExpectEqual(const std::optional<PositionPrior>& a, const std::optional<PositionPrior>& b) {
  ASSERT_EQ(a.has_value(), b.has_value());
  if (a) {
    const auto& [position, accuracy_m, height_sigma_m, source] = *a;
    ExpectEqual(position, b->position);
    EXPECT_EQ(accuracy_m, b->accuracy_m);
    EXPECT_EQ(height_sigma_m, b->height_sigma_m);
    EXPECT_EQ(source, b->source);
  }
}

void ExpectEqual(const RigCamera& a, const RigCamera& b) {
  const auto& [camera, cam_from_first, features] = a;
  ExpectEqual(camera, b.camera);
  ExpectEqual(cam_from_first.rotation, b.cam_from_first.rotation);
  EXPECT_EQ(cam_from_first.translation, b.cam_from_first.translation);
  EXPECT_EQ(features.size(), b.features.size());
}

void ExpectEqual(const std::optional<FocalPrior>& a, const std::optional<FocalPrior>& b) {
  ASSERT_EQ(a.has_value(), b.has_value());
  if (a) {
    const auto& [log_sigma, with_distortion] = *a;
    EXPECT_EQ(log_sigma, b->log_sigma);
    EXPECT_EQ(with_distortion, b->with_distortion);
  }
}

void ExpectEqual(const ResponseOptions& a, const ResponseOptions& b) {
  const auto& [inner_frame, max_matches, with_matches, with_timings, with_covariance] = a;
  EXPECT_EQ(inner_frame, b.inner_frame);
  EXPECT_EQ(max_matches, b.max_matches);
  EXPECT_EQ(with_matches, b.with_matches);
  EXPECT_EQ(with_timings, b.with_timings);
  EXPECT_EQ(with_covariance, b.with_covariance);
}

void ExpectEqual(const WireRequest& a, const WireRequest& b) {
  const auto& [id, timestamp_ms, camera, focal, other_cameras, prior, down_in_cam, timeout_ms,
               picture, exif_prior, answer] = a;
  EXPECT_EQ(id, b.id);
  EXPECT_EQ(timestamp_ms, b.timestamp_ms);
  ExpectEqual(camera, b.camera);
  ExpectEqual(focal, b.focal);
  ASSERT_EQ(other_cameras.size(), b.other_cameras.size());
  for (size_t i = 0; i < other_cameras.size(); ++i) {
    ExpectEqual(other_cameras[i], b.other_cameras[i]);
  }
  ExpectEqual(prior, b.prior);
  EXPECT_EQ(down_in_cam, b.down_in_cam);
  EXPECT_EQ(timeout_ms, b.timeout_ms);
  EXPECT_EQ(picture, b.picture);
  EXPECT_EQ(exif_prior, b.exif_prior);
  ExpectEqual(answer, b.answer);
}

WireRequest FullRequest() {
  return {.id = "q1",
          .timestamp_ms = 1750939398316,
          .camera = Camera(CameraModel::kRadial, 640, 480, {501.5, 320, 240, -0.05, 0.01}),
          .focal = FocalPrior{.log_sigma = 0.125},
          .other_cameras = {},
          .prior = PositionPrior{.position = Geodetic::FromDegrees(47.5, -8.25, 408.5),
                                 .accuracy_m = 12.5,
                                 .height_sigma_m = 4.5},
          .down_in_cam = Eigen::Vector3d(0.0, 1.0, 0.0),
          .timeout_ms = 4321,
          .picture = ImageOrientation::kUpright,
          .exif_prior = false,
          .answer = {.inner_frame = InnerFrame::kRub,
                     .max_matches = 7,
                     .with_matches = true,
                     .with_timings = false,
                     .with_covariance = false}};
}

WireRequest ReadBack(const WireRequest& request) {
  const std::string text = WireRequestJson(request);
  return ReadWireRequest(JsonReader(ParseJson(text)));
}

TEST(WireRequest, ReadsBackWithEveryMember) {
  ExpectEqual(FullRequest(), ReadBack(FullRequest()));
  ExpectEqual(WireRequest(), ReadBack(WireRequest()));
  for (const ImageOrientation picture : {ImageOrientation::kAsSize, ImageOrientation::kStored}) {
    WireRequest request = FullRequest();
    request.picture = picture;
    ExpectEqual(request, ReadBack(request));
  }
}

TEST(WireRequest, ReadsBackEachContentThatIsWanted) {
  for (int i = 0; i < 8; ++i) {
    WireRequest request = FullRequest();
    request.answer.with_matches = (i & 1) != 0;
    request.answer.with_timings = (i & 2) != 0;
    request.answer.with_covariance = (i & 4) != 0;
    ExpectEqual(request, ReadBack(request));
  }
}

TEST(WireRequest, ReadsBackEachInnerFrame) {
  for (const InnerFrame frame :
       {InnerFrame::kFlu, InnerFrame::kRdf, InnerFrame::kRub, InnerFrame::kEus}) {
    WireRequest request = FullRequest();
    request.answer.inner_frame = frame;
    ExpectEqual(request, ReadBack(request));
  }
}

TEST(WireRequest, ReadsBackARig) {
  WireRequest request = FullRequest();
  request.focal.reset();  // The cameras of a rig are known.
  request.other_cameras.assign(RigCamera::kMaxOthers, {});
  for (int i = 0; i < RigCamera::kMaxOthers; ++i) {
    request.other_cameras[i].camera =
        Camera(CameraModel::kSimplePinhole, 100 + i, 50, {80.0 + i, 50, 25});
    request.other_cameras[i].cam_from_first =
        Rigid3d(ExpSo3({0.1 * i, -0.2, 0.3}), Eigen::Vector3d(0.5, 0.25 * i, -1.0));
  }
  ExpectEqual(request, ReadBack(request));
}

TEST(WireRequest, StatesOnlyTheSizeOfAnUnknownCamera) {
  WireRequest request = FullRequest();
  request.camera = CameraOfUnknownFocal(640, 480);
  request.focal = FocalPrior{.with_distortion = true};
  const std::string text = WireRequestJson(request);
  EXPECT_FALSE(nlohmann::json::parse(text)["camera"].contains("modelParams"));
  ExpectEqual(request, ReadBack(request));
}

// A server of an older version refuses members that it does not know.
TEST(WireRequest, LeavesOutWhatOlderServersDoNotKnow) {
  const auto options = nlohmann::json::parse(WireRequestJson({}))["options"];
  EXPECT_FALSE(options.contains("exifPrior"));
  EXPECT_FALSE(options.contains("imageOrientation"));
}

TEST(WireRequest, SurvivesAnIdThatIsNotUtf8) {
  WireRequest request = FullRequest();
  request.id = "\xff\xfe";
  EXPECT_FALSE(ReadBack(request).id.empty());
}

void ExpectEqual(const WireAccuracy& a, const WireAccuracy& b) {
  const auto& [position_m, rotation_rad] = a;
  EXPECT_EQ(position_m, b.position_m);
  EXPECT_NEAR(rotation_rad, b.rotation_rad, 1e-15);
}

void ExpectEqual(const CameraEstimate& a, const CameraEstimate& b) {
  const auto& [camera, focal_sigma_px, assumed_focal_px, assumed_focal_sigma_px, focal_disagrees,
               is_off_center] = a;
  ExpectEqual(camera, b.camera);
  EXPECT_EQ(focal_sigma_px, b.focal_sigma_px);
  EXPECT_EQ(assumed_focal_px, b.assumed_focal_px);
  EXPECT_EQ(assumed_focal_sigma_px, b.assumed_focal_sigma_px);
  EXPECT_EQ(focal_disagrees, b.focal_disagrees);
  EXPECT_EQ(is_off_center, b.is_off_center);
}

void ExpectEqual(const WirePose& a, const WirePose& b) {
  const auto& [geopose, inner_frame, anchor, accuracy, accuracy_on_earth, covariance, camera,
               confidence, score, false_alarm_rate, prior_disagrees, num_inliers] = a;
  const auto& [position, enu_from_inner] = geopose;
  ExpectEqual(position, b.geopose.position);
  ExpectEqual(enu_from_inner, b.geopose.enu_from_inner);
  EXPECT_EQ(inner_frame, b.inner_frame);
  ExpectEqual(anchor, b.anchor);
  ExpectEqual(accuracy, b.accuracy);
  ASSERT_EQ(accuracy_on_earth.has_value(), b.accuracy_on_earth.has_value());
  if (accuracy_on_earth) {
    ExpectEqual(*accuracy_on_earth, *b.accuracy_on_earth);
  }
  EXPECT_EQ(covariance, b.covariance);
  ASSERT_EQ(camera.has_value(), b.camera.has_value());
  if (camera) {
    ExpectEqual(*camera, *b.camera);
  }
  EXPECT_EQ(confidence, b.confidence);
  EXPECT_EQ(score, b.score);
  EXPECT_EQ(false_alarm_rate, b.false_alarm_rate);
  EXPECT_EQ(prior_disagrees, b.prior_disagrees);
  EXPECT_EQ(num_inliers, b.num_inliers);
}

void ExpectEqual(const WireMatch& a, const WireMatch& b) {
  const auto& [pixel, landmark_id, x_in_anchor, sigma_m, error_px, right_probability, keypoint_idx,
               tile_idx, camera_idx] = a;
  EXPECT_EQ(pixel, b.pixel);
  EXPECT_EQ(landmark_id, b.landmark_id);
  EXPECT_EQ(x_in_anchor, b.x_in_anchor);
  EXPECT_EQ(sigma_m, b.sigma_m);
  EXPECT_EQ(error_px, b.error_px);
  EXPECT_EQ(right_probability, b.right_probability);
  EXPECT_EQ(keypoint_idx, b.keypoint_idx);
  EXPECT_EQ(tile_idx, b.tile_idx);
  EXPECT_EQ(camera_idx, b.camera_idx);
}

void ExpectEqual(const WireResponse& a, const WireResponse& b) {
  const auto& [id, timestamp_ms, pose, reason, reason_text, prior, is_upright, matches, map_version,
               map_is_stale, tiles] = a;
  EXPECT_EQ(id, b.id);
  EXPECT_EQ(timestamp_ms, b.timestamp_ms);
  ASSERT_EQ(pose.has_value(), b.pose.has_value());
  if (pose) {
    ExpectEqual(*pose, *b.pose);
  }
  EXPECT_EQ(reason, b.reason);
  EXPECT_EQ(reason_text, b.reason_text);
  ExpectEqual(prior, b.prior);
  EXPECT_EQ(is_upright, b.is_upright);
  ASSERT_EQ(matches.has_value(), b.matches.has_value());
  if (matches) {
    ASSERT_EQ(matches->size(), b.matches->size());
    for (size_t i = 0; i < matches->size(); ++i) {
      ExpectEqual((*matches)[i], (*b.matches)[i]);
    }
  }
  EXPECT_EQ(map_version, b.map_version);
  EXPECT_EQ(map_is_stale, b.map_is_stale);
  EXPECT_EQ(tiles, b.tiles);
}

// Values that differ from each other and from the defaults.
WirePose FullPose() {
  WirePose pose{.geopose = {.position = Geodetic::FromDegrees(47.5, -8.25, 408.5),
                            .enu_from_inner = Eigen::Quaterniond(0.5, -0.5, 0.1, 0.7).normalized()},
                .inner_frame = InnerFrame::kRub,
                .anchor = Geodetic::FromDegrees(47.25, -8.5, 1.5),
                .accuracy = {0.31, 0.015},
                .accuracy_on_earth = WireAccuracy{0.62, 0.03},
                .camera = CameraEstimate{.camera = Camera(CameraModel::kSimpleRadial, 640, 480,
                                                          {501.5, 320, 240, -0.05}),
                                         .focal_sigma_px = 2.5,
                                         .assumed_focal_px = 544,
                                         .assumed_focal_sigma_px = 190.5,
                                         .focal_disagrees = true,
                                         .is_off_center = true},
                .confidence = 0.97,
                .score = 88.5,
                .false_alarm_rate = 1e-9,
                .prior_disagrees = true,
                .num_inliers = 1234};
  pose.covariance.emplace();
  for (int i = 0; i < 36; ++i) {
    (*pose.covariance)(i / 6, i % 6) = 1.0 / (1 + i / 6 + i % 6);
  }
  return pose;
}

WireResponse FullResponse() {
  return {.id = "q1",
          .timestamp_ms = -5,
          .pose = FullPose(),
          .reason = {},
          .reason_text = {},
          .prior = PositionPrior{.position = Geodetic::FromDegrees(47.75, -8.75, 2.5),
                                 .accuracy_m = 12.5,
                                 .height_sigma_m = {},
                                 .source = PriorSource::kPhoto},
          .is_upright = true,
          .matches = {{WireMatch(), WireMatch{.pixel = {10.5, 20.25},
                                              .landmark_id = uint64_t{1} << 53,
                                              .x_in_anchor = {1.5, 2.5, 3.5},
                                              .sigma_m = 0.125,
                                              .error_px = 0.75,
                                              .right_probability = 0.25,
                                              .keypoint_idx = 9,
                                              .tile_idx = 1,
                                              .camera_idx = 7}}},
          .map_version = 42,
          .map_is_stale = true,
          .tiles = {TileId::Parse("32N-03104-35120"), TileId::Parse("32N-03105-35120")}};
}

WireResponse ReadBack(const WireResponse& response) {
  const std::string text = WireResponseJson(response).dump();
  return ReadWireResponse(JsonReader(ParseJson(text)));
}

TEST(WireResponse, ReadsBackWithEveryMember) {
  ExpectEqual(FullResponse(), ReadBack(FullResponse()));
}

TEST(WireResponse, ReadsBackAMiss) {
  const WireResponse miss{.reason = "NO_COVERAGE", .reason_text = "no tile is near"};
  ExpectEqual(miss, ReadBack(miss));
}

TEST(WireResponse, ReadsBackWithoutWhatWasNotAskedFor) {
  WireResponse response = FullResponse();
  response.matches.reset();
  response.prior.reset();
  response.timestamp_ms.reset();
  response.pose->covariance.reset();
  response.pose->camera.reset();
  response.pose->accuracy_on_earth.reset();
  ExpectEqual(response, ReadBack(response));
}

// A match of a tile that the response does not have.
TEST(WireResponse, RefusesMatchesOutsideItsTiles) {
  WireResponse response = FullResponse();
  response.tiles.pop_back();
  try {
    ReadBack(response);
    FAIL();
  } catch (const JsonError& error) {
    EXPECT_EQ(error.pointer(), "/matches/1/tile");
  }
}

TEST(WireResponse, RefusesAQuaternionThatIsNoRotation) {
  WireResponse response = FullResponse();
  response.pose->geopose.enu_from_inner.coeffs() *= 1.01;
  EXPECT_THROW(ReadBack(response), JsonError);
}

std::set<std::string> NamesOf(const nlohmann::json& object) {
  std::set<std::string> names;
  for (const auto& [name, value] : object.items()) {
    names.insert(name);
  }
  return names;
}

// What openapi.json says of a message.
nlohmann::json DescriptionOf(const std::string& message) {
  const std::string text =
      ReadTextFile(std::string(CAIRN_SOURCE_DIR) + "/http/openapi.json", uint64_t{1} << 20);
  return nlohmann::json::parse(text)["components"]["schemas"][message]["properties"];
}

TEST(WireRequest, HasTheMembersThatAreDescribed) {
  WireRequest request = FullRequest();
  request.other_cameras.resize(1);
  const auto json = nlohmann::json::parse(WireRequestJson(request));
  const nlohmann::json described = DescriptionOf("LocalizeRequest");
  std::set<std::string> names = NamesOf(json);
  names.insert({"image", "features"});
  EXPECT_EQ(names, NamesOf(described));
  EXPECT_EQ(NamesOf(json["options"]), NamesOf(described["options"]["properties"]));
}

TEST(WireResponse, HasTheMembersThatAreDescribed) {
  const nlohmann::json json = WireResponseJson(FullResponse());
  const nlohmann::json described = DescriptionOf("LocalizeResponse");
  std::set<std::string> names = NamesOf(json);
  names.insert({"reasonText", "stages"});
  EXPECT_EQ(names, NamesOf(described));
  EXPECT_EQ(NamesOf(json["camera"]), NamesOf(described["camera"]["properties"]));
  EXPECT_EQ(NamesOf(json["matches"][1]), NamesOf(DescriptionOf("Match")));
}

}  // namespace
}  // namespace cairn
