#include "engine/query/localize_query.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include "core/error.h"

namespace cairn {
namespace {

LocalizeQuery GoodQuery() {
  LocalizeQuery query;
  query.features.keypoints = {{10.0f, 20.0f, 2.0f, 0.5f}};
  query.features.descriptors = DescriptorMatrix::Ones(1, 128);
  query.prior = PositionPrior{Geodetic::FromDegrees(47.0, 8.0, 400.0), 10.0, 5.0};
  query.down_in_cam = Eigen::Vector3d(0.0, 1.0, 0.0);
  return query;
}

// Expects a refusal that names `field`.
void ExpectRefused(const std::function<void(LocalizeQuery*)>& spoil, const std::string& field) {
  LocalizeQuery query = GoodQuery();
  spoil(&query);
  try {
    query.Validate();
    FAIL() << "accepted a bad " << field;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kBadInput);
    EXPECT_NE(std::string(error.what()).find(field), std::string::npos) << error.what();
  }
}

TEST(LocalizeQuery, AcceptsAGoodOne) { EXPECT_NO_THROW(GoodQuery().Validate()); }

TEST(LocalizeQuery, RefusalsNameTheField) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  ExpectRefused([](auto* q) { q->prior->accuracy_m = 0.0; }, "accuracy");
  ExpectRefused([&](auto* q) { q->prior->accuracy_m = nan; }, "accuracy");
  ExpectRefused([](auto* q) { q->prior->accuracy_m = 1e9; }, "accuracy");
  ExpectRefused([](auto* q) { q->prior->height_sigma_m = -1.0; }, "altitudeAccuracy");
  ExpectRefused([&](auto* q) { q->prior->position.lat_rad = nan; }, "latitude");
  ExpectRefused([](auto* q) { q->down_in_cam = Eigen::Vector3d(0, 2, 0); }, "gravity");
  ExpectRefused([&](auto* q) { q->down_in_cam = Eigen::Vector3d(nan, 0, 0); }, "gravity");
  ExpectRefused([](auto* q) { q->features.keypoints.clear(); }, "features");
}

}  // namespace
}  // namespace cairn
