#include "mapping/session/stage_codec.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "mapping/street_segment.h"

namespace cairn {
namespace {

Growth GrowthOf(const testing::StreetSegment& street) {
  Growth growth;
  growth.segments = {street.segment};
  growth.verdict_of_photo.assign(street.set.photos.size(), PhotoVerdict::kInSegment);
  growth.verdict_of_photo[0] = PhotoVerdict::kLostSupport;
  return growth;
}

TEST(StageCodec, KeepsEveryBitOfAGrowth) {
  const testing::StreetSegment street = testing::MakeStreetSegment(1.0);
  const std::vector<uint8_t> bytes = EncodeGrowth(GrowthOf(street));
  const Growth decoded = DecodeGrowth(bytes, street.set, "segments");
  ASSERT_EQ(decoded.segments.size(), 1u);
  const Reconstruction& model = decoded.segments[0].model;
  EXPECT_EQ(model.images.size(), street.segment.model.images.size());
  EXPECT_EQ(model.images[3].cam_from_world.translation,
            street.segment.model.images[3].cam_from_world.translation);
  EXPECT_EQ(model.images[3].name, street.segment.model.images[3].name);
  EXPECT_EQ(decoded.verdict_of_photo[0], PhotoVerdict::kLostSupport);
  EXPECT_EQ(EncodeGrowth(decoded), bytes);
}

TEST(StageCodec, KeepsEveryBitOfAnAdjustedSegment) {
  const testing::StreetSegment street = testing::MakeStreetSegment(1.0);
  AdjustedSegment adjusted;
  adjusted.segment = street.segment;
  adjusted.origin = Geodetic::FromDegrees(47.0, 8.5, 400.0);
  adjusted.report = {.num_rounds = 2,
                     .num_iterations = 9,
                     .initial_cost = 7.5,
                     .final_cost = 6.25,
                     .rms_px = 0.4,
                     .num_observations = int64_t{1} << 40,
                     .num_observations_removed = 3,
                     .num_landmarks_removed = 1};
  const std::vector<uint8_t> bytes = EncodeAdjusted(adjusted);
  const AdjustedSegment decoded = DecodeAdjusted(bytes, street.set, "adjusted-0");
  EXPECT_EQ(decoded.origin.lat_rad, adjusted.origin.lat_rad);
  EXPECT_EQ(decoded.report.num_observations, int64_t{1} << 40);
  EXPECT_EQ(decoded.report.num_landmarks_removed, 1);
  EXPECT_EQ(decoded.segment.photo_of_image, street.segment.photo_of_image);
  EXPECT_EQ(EncodeAdjusted(decoded), bytes);
}

TEST(StageCodec, KeepsPairs) {
  const testing::StreetSegment street = testing::MakeStreetSegment(1.0);
  const std::vector<std::pair<int, int>> pairs = {{0, 3}, {2, 1}};
  EXPECT_EQ(DecodePairs(EncodePairs(pairs), street.set, "pairs"), pairs);
  const std::vector<std::pair<int, int>> foreign = {{0, 16}};
  EXPECT_THROW(DecodePairs(EncodePairs(foreign), street.set, "pairs"), Error);
}

TEST(StageCodec, KeepsEveryBitOfTwoViews) {
  const testing::StreetSegment street = testing::MakeStreetSegment(1.0);
  TwoView view;
  view.a = 1;
  view.b = 2;
  view.b_from_a = {Eigen::Quaterniond(0.9, 0.1, 0.2, 0.3), Eigen::Vector3d(0.1, 0.2, 0.3)};
  view.inliers = {{3, 4, 0.5f}, {5, 6, 0.25f}};
  view.parallax_rad = 0.1;
  view.focal_factor_b = 1.25;
  const std::vector<uint8_t> bytes = EncodeTwoViews({&view, 1});
  const std::vector<TwoView> decoded = DecodeTwoViews(bytes, street.set, "views");
  ASSERT_EQ(decoded.size(), 1u);
  EXPECT_EQ(decoded[0].inliers[1].b_idx, 6);
  EXPECT_EQ(decoded[0].focal_factor_b, 1.25);
  EXPECT_EQ(EncodeTwoViews(decoded), bytes);
}

TEST(StageCodec, KeepsEveryBitOfCameras) {
  testing::StreetSegment street = testing::MakeStreetSegment(1.0);
  std::vector<MappingCamera> cameras = street.set.cameras;
  cameras[0].source = FocalSource::kPhotos;
  cameras[0].focal.log_sigma = 0.07;
  const std::vector<uint8_t> bytes = EncodeCameras(cameras);
  const std::vector<MappingCamera> decoded = DecodeCameras(bytes, street.set, "cameras");
  ASSERT_EQ(decoded.size(), cameras.size());
  EXPECT_EQ(decoded[0].source, FocalSource::kPhotos);
  EXPECT_EQ(decoded[0].focal.log_sigma, 0.07);
  EXPECT_EQ(decoded[0].camera.params(), cameras[0].camera.params());
  EXPECT_EQ(EncodeCameras(decoded), bytes);
  std::vector<uint8_t> damaged = bytes;
  damaged.back() = 9;  // A source that there is not.
  EXPECT_THROW(DecodeCameras(damaged, street.set, "cameras"), Error);
  EXPECT_THROW(DecodeCameras({bytes.data(), bytes.size() - 1}, street.set, "cameras"), Error);
  street.set.cameras.push_back(cameras[0]);
  EXPECT_THROW(DecodeCameras(bytes, street.set, "cameras"), Error);
}

TEST(StageCodec, RefusesBytesThatDoNotFitThePhotos) {
  testing::StreetSegment street = testing::MakeStreetSegment(1.0);
  const std::vector<uint8_t> bytes = EncodeGrowth(GrowthOf(street));
  for (size_t cut = 0; cut < bytes.size(); cut += 1 + bytes.size() / 50) {
    EXPECT_THROW(DecodeGrowth({bytes.data(), cut}, street.set, "segments"), Error) << cut;
  }
  street.set.photos.back().keypoints.resize(3);
  EXPECT_THROW(DecodeGrowth(bytes, street.set, "segments"), Error);
  street.set.photos.pop_back();
  EXPECT_THROW(DecodeGrowth(bytes, street.set, "segments"), Error);
}

}  // namespace
}  // namespace cairn
