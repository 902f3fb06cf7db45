// Tests real photos that show nothing of the map. None may get an answer that claims to be right.
#include "eval/elsewhere.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "support/test_data.h"
#include "system/real_drive.h"

namespace cairn::testing {
namespace {

std::unique_ptr<RealDrive> SparseLund() {
  RealDriveInput input = LundInput();
  input.is_query = [](const std::string& name) { return std::stoi(name) % 3 != 0; };
  return std::make_unique<RealDrive>(input);
}

std::unique_ptr<RealDrive> SparseKitti() {
  RealDriveInput input = KittiInput();
  input.is_query = [](const std::string& name) { return std::stoi(name) % 3 != 0; };
  return std::make_unique<RealDrive>(input);
}

std::vector<Geodetic> PlacesOf(const RealDrive& drive) {
  std::vector<Geodetic> places;
  for (const EvalQuery& query : drive.queries()) {
    places.push_back(GeodeticFromEcef(query.cam_from_ecef.Inverse().translation));
  }
  return places;
}

ElsewhereReport Ask(const RealDrive& map, const std::vector<EvalQuery>& queries) {
  std::vector<EvalAnswer> answers;
  for (const EvalQuery& query : queries) {
    answers.push_back({.name = query.name, .result = map.localizer().Localize(query.query)});
  }
  return MeasureElsewhere(answers);
}

void ExpectNothing(const ElsewhereReport& report) {
  EXPECT_EQ(report.num_confident, 0) << ElsewhereAsText(report);
}

// The photos of one place asked for in the other, with a prior and gravity and without.
TEST(Elsewhere, PhotosOfAnotherPlaceAreNotAnswered) {
  CAIRN_SKIP_WITHOUT_DATA("street_lund");
  CAIRN_SKIP_WITHOUT_DATA("kitti_vo_2x51");
  const std::unique_ptr<RealDrive> lund = SparseLund(), kitti = SparseKitti();
  for (const auto& [map, other] : {std::pair{lund.get(), kitti.get()}, {kitti.get(), lund.get()}}) {
    for (const bool with_priors : {true, false}) {
      std::vector<EvalQuery> queries = other->queries();
      PlaceElsewhere(PlacesOf(*map), 1, &queries);
      AddNoisyPriors({.with_prior = with_priors, .with_gravity = with_priors}, &queries);
      ExpectNothing(Ask(*map, queries));
    }
  }
}

TEST(Elsewhere, PhotosWhosePartsArePermutedAreNotAnswered) {
  CAIRN_SKIP_WITHOUT_DATA("street_lund");
  const std::unique_ptr<RealDrive> lund = SparseLund();
  for (const uint64_t seed : {1, 2, 3}) {
    std::vector<EvalQuery> queries = lund->queries();
    PermuteDescriptors(seed, &queries);
    ExpectNothing(Ask(*lund, queries));
  }
}

// On a dense facade, chance finds six sharp inliers for one of the very many poses nearby.
TEST(Elsewhere, SharpInliersByChanceAreNotAnswered) {
  CAIRN_SKIP_WITHOUT_DATA("facades_strecha/colmap_Herz-Jesus-both");
  RealDriveInput input = HerzJesusInput();
  input.is_query = [](const std::string& name) { return name == "a_0006.jpg"; };
  input.is_left_out = [](const std::string& name) {
    const int index = std::stoi(name.substr(2));
    return name != "a_0006.jpg" && (name[0] == 'a' ? index % 3 == 0 : index % 3 == 1);
  };
  const RealDrive facade(input);
  std::vector<EvalQuery> queries = facade.queries();
  PermuteDescriptors(1, &queries);
  ExpectNothing(Ask(facade, queries));
}

}  // namespace
}  // namespace cairn::testing
