#include "eval/elsewhere.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/error.h"

namespace cairn {
namespace {

std::vector<EvalQuery> SomeQueries(int count) {
  const Geodetic place = Geodetic::FromDegrees(47.0, 8.0, 400.0);
  std::vector<EvalQuery> queries(count);
  for (int i = 0; i < count; ++i) {
    queries[i].name = "photo " + std::to_string(i);
    queries[i].cam_from_ecef =
        Rigid3d(ExpSo3({0.1 * i, 0.2, 0.3}), {0, 0, 0}) * EcefFromEnu(place).Inverse();
    FeatureSet& features = queries[i].query.features;
    features.keypoints.resize(50);
    features.descriptors.resize(50, 2);
    for (int k = 0; k < 50; ++k) {
      features.descriptors.row(k) << static_cast<float>(k), static_cast<float>(i);
    }
  }
  return queries;
}

Rigid3d CamFromEnu(const EvalQuery& query) {
  return query.cam_from_ecef *
         EcefFromEnu(GeodeticFromEcef(query.cam_from_ecef.Inverse().translation));
}

TEST(PlaceElsewhere, MovesCamerasToThePlacesAndKeepsTheirOrientation) {
  const std::vector<Geodetic> places = {Geodetic::FromDegrees(-33.0, 151.0, 20.0),
                                        Geodetic::FromDegrees(64.0, -22.0, 60.0)};
  const std::vector<EvalQuery> before = SomeQueries(20);
  std::vector<EvalQuery> moved = before;
  PlaceElsewhere(places, 1, &moved);
  std::vector<int> num_at(places.size(), 0);
  for (size_t i = 0; i < moved.size(); ++i) {
    const Geodetic now = GeodeticFromEcef(moved[i].cam_from_ecef.Inverse().translation);
    for (size_t k = 0; k < places.size(); ++k) {
      num_at[k] += GroundDistanceM(now, places[k]) < 1e-3;
    }
    EXPECT_LT(RotationAngleRad(CamFromEnu(moved[i]).rotation, CamFromEnu(before[i]).rotation),
              1e-9);
  }
  EXPECT_GT(num_at[0], 0);
  EXPECT_GT(num_at[1], 0);
  EXPECT_EQ(num_at[0] + num_at[1], 20);
}

TEST(PermuteDescriptors, KeepsThemAllButNotTheirPlaces) {
  const std::vector<EvalQuery> before = SomeQueries(3);
  std::vector<EvalQuery> permuted = before;
  PermuteDescriptors(7, &permuted);
  for (size_t i = 0; i < before.size(); ++i) {
    const DescriptorMatrix& old_rows = before[i].query.features.descriptors;
    const DescriptorMatrix& new_rows = permuted[i].query.features.descriptors;
    std::vector<float> of_old(old_rows.col(0).begin(), old_rows.col(0).end());
    std::vector<float> of_new(new_rows.col(0).begin(), new_rows.col(0).end());
    EXPECT_NE(of_new, of_old);
    std::sort(of_new.begin(), of_new.end());
    EXPECT_EQ(of_new, of_old);
  }
  std::vector<EvalQuery> again = before;
  PermuteDescriptors(7, &again);
  EXPECT_EQ(again[0].query.features.descriptors, permuted[0].query.features.descriptors);
}

TEST(MeasureElsewhere, CountsAnswersByConfidence) {
  std::vector<EvalAnswer> answers(200);
  for (const auto& [i, confidence] : {std::pair{3, 0.3}, {50, 0.6}, {120, 0.95}}) {
    answers[i].result.localized = true;
    answers[i].result.confidence = confidence;
  }
  answers[4].result.confidence = 0.99;  // Not localized: does not count.
  const ElsewhereReport report = MeasureElsewhere(answers);
  EXPECT_EQ(report.num_queries, 200);
  EXPECT_EQ(report.num_answered, 3);
  EXPECT_EQ(report.num_confident, 2);
  EXPECT_EQ(report.num_sure, 1);
  EXPECT_DOUBLE_EQ(report.share_confident.value, 0.01);
  EXPECT_LT(report.share_confident.low, 0.01);
  EXPECT_GT(report.share_confident.high, 0.01);
  EXPECT_DOUBLE_EQ(report.highest_confidence, 0.95);
  EXPECT_THAT(ElsewhereAsText(report), ::testing::HasSubstr("3 of 200 queries from elsewhere"));
}

TEST(MeasureElsewhere, RefusesNothing) { EXPECT_THROW(MeasureElsewhere({}), Error); }

}  // namespace
}  // namespace cairn
