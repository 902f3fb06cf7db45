#include "core/wire/feature_codec.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <random>

#include "core/keypoint_shape.h"
#include "core/wire/problem.h"

namespace cairn {
namespace {

constexpr int kMaxFeatures = 5000;

WireFeatures RandomFeatures(int count, int dim, DescriptorSpace space, bool integers) {
  std::mt19937 rng(7);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  WireFeatures wire;
  wire.width_px = 640;
  wire.height_px = 480;
  wire.codec = space == DescriptorSpace::kRaw ? "sift" : "sift-128-16-1";
  wire.features.space = space;
  wire.features.descriptors.resize(count, dim);
  for (int i = 0; i < count; ++i) {
    wire.features.keypoints.push_back({unit(rng) * 640.0f, unit(rng) * 480.0f,
                                       1.0f + 20.0f * unit(rng), 6.28f * unit(rng) - 3.14f});
    for (int d = 0; d < dim; ++d) {
      const float value = unit(rng);
      wire.features.descriptors(i, d) = integers ? std::floor(255.0f * value) : value - 0.5f;
    }
  }
  return wire;
}

ProblemCode ProblemOf(std::span<const uint8_t> blob, int max_features = kMaxFeatures) {
  try {
    DecodeFeatures(blob, max_features);
  } catch (const HttpError& e) {
    EXPECT_EQ(e.pointer(), "/features");
    return e.problem();
  }
  ADD_FAILURE() << "decoded";
  return ProblemCode::kInternal;
}

void ExpectSameKeypoints(const FeatureSet& a, const FeatureSet& b) {
  ASSERT_EQ(a.size(), b.size());
  for (int i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a.keypoints[i].x_px, b.keypoints[i].x_px);
    EXPECT_EQ(a.keypoints[i].y_px, b.keypoints[i].y_px);
    EXPECT_EQ(a.keypoints[i].scale_px, b.keypoints[i].scale_px);
    EXPECT_EQ(a.keypoints[i].orientation_rad, b.keypoints[i].orientation_rad);
  }
}

TEST(FeatureCodec, LosslessEncodingOfRawSiftIsOneByteADimension) {
  const WireFeatures wire = RandomFeatures(500, 128, DescriptorSpace::kRaw, /*integers=*/true);
  const FeatureEncoding encoding = LosslessEncoding(wire.features);
  EXPECT_EQ(encoding.descriptors, DescriptorEncoding::kUint8);
  const std::vector<uint8_t> blob = EncodeFeatures(wire, encoding);
  EXPECT_EQ(blob.size(), 72'028u);  // As docs/formats/features_v1.md says.
  const WireFeatures decoded = DecodeFeatures(blob, kMaxFeatures);
  ExpectSameKeypoints(decoded.features, wire.features);
  EXPECT_EQ(decoded.features.descriptors, wire.features.descriptors);
  EXPECT_EQ(decoded.codec, "sift");
  EXPECT_EQ(decoded.width_px, 640);
  EXPECT_EQ(decoded.height_px, 480);
  EXPECT_EQ(decoded.features.space, DescriptorSpace::kRaw);
}

TEST(FeatureCodec, LosslessEncodingOfRealValuesIsFloat) {
  const WireFeatures wire = RandomFeatures(20, 16, DescriptorSpace::kProjected, false);
  const WireFeatures decoded =
      DecodeFeatures(EncodeFeatures(wire, LosslessEncoding(wire.features)), kMaxFeatures);
  EXPECT_EQ(decoded.features.descriptors, wire.features.descriptors);
  EXPECT_EQ(decoded.features.space, DescriptorSpace::kProjected);
  ExpectSameKeypoints(decoded.features, wire.features);
}

TEST(FeatureCodec, HalfFloatsOfAQueryFitTheBudgetOfTheWire) {
  const WireFeatures wire = RandomFeatures(500, 16, DescriptorSpace::kProjected, false);
  const std::vector<uint8_t> blob =
      EncodeFeatures(wire, {GeometryEncoding::kCompact, DescriptorEncoding::kFloat16});
  EXPECT_EQ(blob.size(), 19'037u);
  const WireFeatures decoded = DecodeFeatures(blob, kMaxFeatures);
  // Half floats in [-0.5, 0.5] have 11 significant bits.
  EXPECT_LT((decoded.features.descriptors - wire.features.descriptors).cwiseAbs().maxCoeff(),
            0.5f / 2048.0f);
}

TEST(FeatureCodec, ScaledBytesAreWithinHalfAStep) {
  const WireFeatures wire = RandomFeatures(500, 16, DescriptorSpace::kProjected, false);
  const std::vector<uint8_t> blob =
      EncodeFeatures(wire, {GeometryEncoding::kCompact, DescriptorEncoding::kUint8Scaled});
  EXPECT_EQ(blob.size(), 11'165u);
  const WireFeatures decoded = DecodeFeatures(blob, kMaxFeatures);
  EXPECT_LT((decoded.features.descriptors - wire.features.descriptors).cwiseAbs().maxCoeff(),
            0.501f / 255.0f);
}

TEST(FeatureCodec, CompactGeometryIsWithinItsStatedSteps) {
  const WireFeatures wire = RandomFeatures(1000, 16, DescriptorSpace::kProjected, false);
  const WireFeatures decoded = DecodeFeatures(
      EncodeFeatures(wire, {GeometryEncoding::kCompact, DescriptorEncoding::kFloat16}),
      kMaxFeatures);
  for (int i = 0; i < wire.features.size(); ++i) {
    const Keypoint& in = wire.features.keypoints[i];
    const Keypoint& out = decoded.features.keypoints[i];
    EXPECT_NEAR(out.x_px, in.x_px, 0.5 * 640.0 / 65535.0 + 1e-4);
    EXPECT_NEAR(out.y_px, in.y_px, 0.5 * 480.0 / 65535.0 + 1e-4);
    EXPECT_NEAR(WrapAngleRad(out.orientation_rad - in.orientation_rad), 0.0, 0.0124);
    EXPECT_NEAR(std::log(out.scale_px / in.scale_px), 0.0, 0.0137);
  }
}

// What a blob leaves out takes no bytes and is unknown to the reader.
TEST(FeatureCodec, SizesAndOrientationsMayBeLeftOut) {
  for (const GeometryEncoding geometry : {GeometryEncoding::kFloat32, GeometryEncoding::kCompact}) {
    const size_t bytes_each = geometry == GeometryEncoding::kFloat32 ? 4 : 1;
    const WireFeatures whole = RandomFeatures(50, 16, DescriptorSpace::kProjected, false);
    const size_t whole_size =
        EncodeFeatures(whole, {geometry, DescriptorEncoding::kFloat16}).size();
    for (const bool has_scale : {false, true}) {
      for (const bool has_orientation : {false, true}) {
        WireFeatures wire = whole;
        for (Keypoint& keypoint : wire.features.keypoints) {
          keypoint.scale_px = has_scale ? keypoint.scale_px : kUnknownScalePx;
          keypoint.orientation_rad =
              has_orientation ? keypoint.orientation_rad : kUnknownOrientationRad;
        }
        const std::vector<uint8_t> blob =
            EncodeFeatures(wire, {geometry, DescriptorEncoding::kFloat16});
        EXPECT_EQ(blob.size(), whole_size - 50 * bytes_each * (!has_scale + !has_orientation));
        const WireFeatures decoded = DecodeFeatures(blob, kMaxFeatures);
        for (int i = 0; i < 50; ++i) {
          const Keypoint& in = wire.features.keypoints[i];
          const Keypoint& out = decoded.features.keypoints[i];
          EXPECT_NEAR(out.x_px, in.x_px, 0.01);
          EXPECT_NEAR(out.y_px, in.y_px, 0.01);
          EXPECT_EQ(HasScale(out), has_scale);
          EXPECT_EQ(HasOrientation(out), has_orientation);
          EXPECT_NEAR(out.scale_px, in.scale_px, 0.02 * in.scale_px);
          EXPECT_TRUE(!has_orientation ||
                      std::abs(WrapAngleRad(out.orientation_rad - in.orientation_rad)) < 0.0124);
        }
      }
    }
  }
}

TEST(FeatureCodec, RefusesUnknownShapesThatTheHeaderDoesNotAnnounce) {
  WireFeatures wire = RandomFeatures(3, 4, DescriptorSpace::kProjected, false);
  const std::vector<uint8_t> good = EncodeFeatures(wire, LosslessEncoding(wire.features));
  const size_t first = 24 + wire.codec.size();
  for (const auto& [offset, value] :
       {std::pair(first + 8, kUnknownScalePx), std::pair(first + 12, kUnknownOrientationRad)}) {
    std::vector<uint8_t> bad = good;
    std::memcpy(bad.data() + offset, &value, sizeof(value));
    EXPECT_EQ(ProblemOf(bad), ProblemCode::kInvalidFeatures);
  }
  wire.features.keypoints[1].scale_px = kUnknownScalePx;  // The others have one.
  EXPECT_THROW(EncodeFeatures(wire, LosslessEncoding(wire.features)), Error);
}

TEST(FeatureCodec, NoFeaturesRoundTrip) {
  WireFeatures wire = RandomFeatures(0, 128, DescriptorSpace::kRaw, true);
  wire.codec.clear();
  const WireFeatures decoded =
      DecodeFeatures(EncodeFeatures(wire, LosslessEncoding(wire.features)), kMaxFeatures);
  EXPECT_EQ(decoded.features.size(), 0);
  EXPECT_EQ(decoded.codec, "");
}

TEST(FeatureCodec, RefusesEveryTruncationAndAnyExtension) {
  const WireFeatures wire = RandomFeatures(3, 8, DescriptorSpace::kProjected, false);
  std::vector<uint8_t> blob =
      EncodeFeatures(wire, {GeometryEncoding::kCompact, DescriptorEncoding::kUint8Scaled});
  for (size_t size = 0; size < blob.size(); ++size) {
    EXPECT_EQ(ProblemOf(std::span(blob).first(size)), ProblemCode::kInvalidFeatures) << size;
  }
  blob.push_back(0);
  EXPECT_EQ(ProblemOf(blob), ProblemCode::kInvalidFeatures);
}

TEST(FeatureCodec, SurvivesEveryFlippedBit) {
  const WireFeatures wire = RandomFeatures(4, 8, DescriptorSpace::kProjected, false);
  const std::vector<uint8_t> blob =
      EncodeFeatures(wire, {GeometryEncoding::kFloat32, DescriptorEncoding::kFloat16});
  for (size_t bit = 0; bit < 8 * blob.size(); ++bit) {
    std::vector<uint8_t> flipped = blob;
    flipped[bit / 8] ^= static_cast<uint8_t>(1u << bit % 8);
    try {
      const WireFeatures decoded = DecodeFeatures(flipped, kMaxFeatures);
      ValidateFeatures(decoded.features, "decoded");  // What it lets through is usable.
    } catch (const HttpError& e) {
      EXPECT_LT(InfoOf(e.problem()).status, 500);
    }
  }
}

TEST(FeatureCodec, RefusesBadHeaders) {
  const WireFeatures wire = RandomFeatures(2, 4, DescriptorSpace::kProjected, false);
  const std::vector<uint8_t> good =
      EncodeFeatures(wire, {GeometryEncoding::kFloat32, DescriptorEncoding::kFloat32});
  const std::pair<size_t, uint8_t> changes[] = {{0, 'X'}, {4, 2},  {6, 2},  {7, 4},   {8, 8},
                                                {9, 65},  {10, 0}, {16, 0}, {24, ' '}};
  for (const auto& [offset, value] : changes) {
    std::vector<uint8_t> bad = good;
    bad[offset] = value;
    if (offset == 10 || offset == 16) {
      bad[offset + 1] = 0;
    }
    EXPECT_EQ(ProblemOf(bad), ProblemCode::kInvalidFeatures) << offset;
  }
}

TEST(FeatureCodec, RefusesACountAboveTheLimitBeforeAllocating) {
  const WireFeatures wire = RandomFeatures(2, 4, DescriptorSpace::kRaw, false);
  std::vector<uint8_t> blob = EncodeFeatures(wire, {});
  EXPECT_EQ(ProblemOf(blob, /*max_features=*/1), ProblemCode::kTooManyFeatures);
  const uint32_t huge = 0xffffffff;
  std::memcpy(blob.data() + 12, &huge, sizeof(huge));
  EXPECT_EQ(ProblemOf(blob), ProblemCode::kTooManyFeatures);
}

TEST(FeatureCodec, RefusesNumbersThatAreNotFiniteAndKeypointsOutside) {
  const WireFeatures wire = RandomFeatures(2, 4, DescriptorSpace::kRaw, false);
  const std::vector<uint8_t> good = EncodeFeatures(wire, {});
  const size_t geometry = 24 + wire.codec.size();
  const float bad_values[] = {std::numeric_limits<float>::quiet_NaN(),
                              std::numeric_limits<float>::infinity(), 1e9f};
  for (const float bad : bad_values) {
    for (size_t offset = geometry; offset + 4 <= good.size(); offset += 4) {
      const bool is_descriptor = offset >= geometry + 32;
      const bool is_orientation = !is_descriptor && (offset - geometry) % 16 == 12;
      if (bad == 1e9f && (is_descriptor || is_orientation)) {
        continue;  // Odd, but finite.
      }
      std::vector<uint8_t> blob = good;
      std::memcpy(blob.data() + offset, &bad, sizeof(bad));
      EXPECT_EQ(ProblemOf(blob), ProblemCode::kInvalidFeatures) << bad << " at " << offset;
    }
  }
}

TEST(FeatureCodec, ProjectedFeaturesNeedACodec) {
  WireFeatures wire = RandomFeatures(2, 4, DescriptorSpace::kProjected, false);
  wire.codec.clear();
  EXPECT_EQ(ProblemOf(EncodeFeatures(wire, {})), ProblemCode::kInvalidFeatures);
}

TEST(FeatureCodec, EncodingRefusesWhatDoesNotFit) {
  WireFeatures wire = RandomFeatures(2, 4, DescriptorSpace::kRaw, false);
  EXPECT_THROW(EncodeFeatures(wire, {GeometryEncoding::kFloat32, DescriptorEncoding::kUint8}),
               Error);
  wire.features.descriptors(0, 0) = 1e6f;
  EXPECT_THROW(EncodeFeatures(wire, {GeometryEncoding::kFloat32, DescriptorEncoding::kFloat16}),
               Error);
  wire.features.descriptors(0, 0) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(EncodeFeatures(wire, {}), Error);
  wire = RandomFeatures(2, 4, DescriptorSpace::kRaw, false);
  wire.features.keypoints[1].x_px = 700.0f;
  EXPECT_THROW(EncodeFeatures(wire, {}), Error);
}

}  // namespace
}  // namespace cairn
