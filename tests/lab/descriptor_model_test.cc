#include "lab/descriptors/descriptor_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/statistics.h"
#include "lab/descriptors/descriptor_statistics.h"
#include "storage/codebook/descriptor_codec.h"

namespace cairn {
namespace {

constexpr int kNumLandmarks = 400;

// RootSIFT of what `look_at` says of each landmark.
template <typename LookAt>
DescriptorMatrix Look(const DescriptorModel& model, const LookAt& look_at) {
  DescriptorMatrix root(kNumLandmarks, DescriptorModel::kDim);
  for (int i = 0; i < kNumLandmarks; ++i) {
    root.row(i) = model.Describe(look_at(static_cast<uint64_t>(i)));
  }
  NormalizeDescriptors(DescriptorNormalization::kRootSift, &root);
  return root;
}

float MedianDistance(const DescriptorMatrix& a, const DescriptorMatrix& b) {
  const Eigen::VectorXf distances = (a - b).rowwise().norm();
  return ValueAtShare(std::vector<float>(distances.begin(), distances.end()), 0.5);
}

DescriptorLook Plain(uint64_t landmark) { return {.ornament = landmark, .landmark = landmark}; }

TEST(DescriptorModel, SameNumbersMakeSameBytes) {
  const DescriptorLook look = {.ornament = 5,
                               .landmark = 12345,
                               .appearance_mode = 2,
                               .view_azimuth_rad = 0.3,
                               .view_elevation_rad = -0.1,
                               .log2_scale = 0.7,
                               .observation = 9};
  const DescriptorModel model({});
  EXPECT_EQ(model.Describe(look), DescriptorModel({}).Describe(look));
  EXPECT_EQ(model.DescribeClutter(3), DescriptorModel({}).DescribeClutter(3));
  EXPECT_NE(model.Describe(look), DescriptorModel({.seed = 2}).Describe(look));
}

TEST(DescriptorModel, EveryNumberMatters) {
  const DescriptorModel model({});
  const DescriptorLook look = {.ornament = 1, .landmark = 1};
  DescriptorLook others[7];
  std::fill(std::begin(others), std::end(others), look);
  others[0].ornament = 2;
  others[1].landmark = 2;
  others[2].appearance_mode = 1;
  others[3].view_azimuth_rad = 0.2;
  others[4].view_elevation_rad = 0.2;
  others[5].log2_scale = 0.2;
  others[6].observation = 1;
  for (const DescriptorLook& other : others) {
    EXPECT_NE(model.Describe(look), model.Describe(other));
  }
  EXPECT_NE(model.DescribeClutter(1), model.DescribeClutter(2));
}

TEST(DescriptorModel, RawIsAsTheExtractorMakesIt) {
  const DescriptorModel model({});
  for (uint64_t i = 0; i < 300; ++i) {
    const DescriptorModel::Descriptor raw =
        i % 2 == 0 ? model.Describe(Plain(i)) : model.DescribeClutter(i);
    EXPECT_GE(raw.minCoeff(), 0.0f);
    EXPECT_LE(raw.maxCoeff(), 255.0f);
    EXPECT_EQ(raw, raw.array().round().matrix());
    EXPECT_LE(raw.norm(), 516.0f);
    EXPECT_GE(raw.norm(), 450.0f);
  }
}

// Of first looks at 3,995 landmarks of a drive and 2,587 of a walk, which agree within a tenth.
TEST(DescriptorModel, SpreadsAlongItsAxesAsRealDescriptorsDo) {
  const Eigen::VectorXf sigmas = PrincipalSigmas(SimulateClutter(4000, DescriptorModel({})));
  constexpr std::pair<int, float> kReal[] = {
      {0, 0.189f},  {1, 0.171f},  {2, 0.164f},  {3, 0.140f},  {5, 0.128f},  {7, 0.114f},
      {11, 0.087f}, {15, 0.075f}, {23, 0.055f}, {31, 0.044f}, {47, 0.033f}, {63, 0.024f}};
  for (const auto& [rank, real] : kReal) {
    EXPECT_NEAR(sigmas[rank], real, 0.2f * real) << rank;
  }
  EXPECT_NEAR(sigmas.squaredNorm(), 0.337f, 0.03f);
}

// Quantiles of the distance to the nearest of `num_others` others, against real ones.
TEST(DescriptorModel, NearestOthersAreAsFarAsReal) {
  struct Real {
    int num_others;
    float low, median, high;  // 5, 50 and 95 %.
  };
  const DescriptorMatrix clutter = SimulateClutter(4000, DescriptorModel({}));
  for (const Real& real : {Real{100, 0.445f, 0.560f, 0.656f}, Real{1000, 0.363f, 0.486f, 0.570f},
                           Real{2500, 0.333f, 0.464f, 0.541f}}) {
    const std::vector<float> distances = NearestDistances(clutter, real.num_others, 1);
    EXPECT_NEAR(ValueAtShare(distances, 0.05), real.low, 0.2f * real.low) << real.num_others;
    EXPECT_NEAR(ValueAtShare(distances, 0.5), real.median, 0.06f * real.median) << real.num_others;
    EXPECT_NEAR(ValueAtShare(distances, 0.95), real.high, 0.06f * real.high) << real.num_others;
  }
}

TEST(DescriptorModel, ClutterCannotBeToldFromLandmarks) {
  const DescriptorModel model({});
  const DescriptorMatrix clutter = SimulateClutter(kNumLandmarks, model);
  const DescriptorMatrix landmarks = Look(model, Plain);
  EXPECT_NEAR(PrincipalSigmas(clutter).squaredNorm(), PrincipalSigmas(landmarks).squaredNorm(),
              0.03f);
  EXPECT_LT((clutter.colwise().mean() - landmarks.colwise().mean()).norm(), 0.1f);
}

TEST(DescriptorModel, LooksDifferMoreTheFurtherApartTheViews) {
  const DescriptorModel model({});
  const DescriptorMatrix front = Look(model, Plain);
  for (const auto field : {&DescriptorLook::view_azimuth_rad, &DescriptorLook::view_elevation_rad,
                           &DescriptorLook::log2_scale}) {
    float last = 0.0f;
    for (const double difference : {0.0, 0.1, 0.25, 0.5, 1.0}) {
      const float distance = MedianDistance(front, Look(model, [&](uint64_t i) {
                                              DescriptorLook look = Plain(i);
                                              look.observation = 1;
                                              look.*field = difference;
                                              return look;
                                            }));
      EXPECT_GT(distance, last + 0.01f) << difference;
      last = distance;
    }
    EXPECT_LT(last, 0.5f);  // Still nearer than strangers.
  }
}

TEST(DescriptorModel, NoModeIsSpecial) {
  const DescriptorModel model({});
  const auto in_mode = [](uint32_t mode, uint64_t observation) {
    return [=](uint64_t i) {
      DescriptorLook look = Plain(i);
      look.appearance_mode = mode;
      look.observation = observation;
      return look;
    };
  };
  const float same = MedianDistance(Look(model, in_mode(0, 0)), Look(model, in_mode(0, 1)));
  const float from_zero = MedianDistance(Look(model, in_mode(0, 0)), Look(model, in_mode(1, 1)));
  const float others = MedianDistance(Look(model, in_mode(3, 0)), Look(model, in_mode(2, 1)));
  EXPECT_GT(from_zero, 1.1f * same);
  EXPECT_NEAR(from_zero, others, 0.1f * others);
}

TEST(DescriptorModel, SiblingsAreNearerThanStrangersAndFurtherThanOneself) {
  const DescriptorModel model({});
  const auto look_at = [](uint64_t ornament, uint64_t landmark, uint64_t observation) {
    return DescriptorLook{.ornament = ornament, .landmark = landmark, .observation = observation};
  };
  const DescriptorMatrix first = Look(model, [&](uint64_t i) { return look_at(i, 2 * i, 0); });
  const float self =
      MedianDistance(first, Look(model, [&](uint64_t i) { return look_at(i, 2 * i, 1); }));
  const float sibling =
      MedianDistance(first, Look(model, [&](uint64_t i) { return look_at(i, 2 * i + 1, 0); }));
  const float stranger = MedianDistance(
      first, Look(model, [&](uint64_t i) { return look_at(i + 5000, 2 * i + 1, 0); }));
  EXPECT_GT(sibling, 1.5f * self);
  EXPECT_LT(sibling, 0.6f * stranger);
}

TEST(DescriptorModelOptions, RefuseNonsense) {
  const auto refuses = [](auto change) {
    DescriptorModelOptions options;
    change(&options);
    EXPECT_THROW(DescriptorModel{options}, Error);
  };
  refuses([](auto* options) { options->axes.clear(); });
  refuses([](auto* options) { options->axes.pop_back(); });
  refuses([](auto* options) { std::swap(options->axes[1], options->axes[2]); });
  refuses([](auto* options) { options->axes[1].between = -1.0f; });
  refuses([](auto* options) { options->axes[1].within = 0.0f; });
  refuses([](auto* options) { options->cluster_share = 0.4; });
  refuses([](auto* options) { options->noise_length = -0.1; });
  refuses([](auto* options) { options->view_length = std::nan(""); });
  refuses([](auto* options) { options->view_angle_scale_rad = 0.0; });
  refuses([](auto* options) { options->view_log2_scale = -1.0; });
}

}  // namespace
}  // namespace cairn
