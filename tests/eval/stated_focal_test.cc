#include "eval/stated_focal.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/error.h"

namespace cairn {
namespace {

std::vector<EvalQuery> Queries(int count) {
  std::vector<EvalQuery> queries(count);
  for (int i = 0; i < count; ++i) {
    queries[i].name = fmt::format("photo {}", i);
  }
  return queries;
}

TEST(StatedFocal, IsTooLongOrTooShortByTheName) {
  std::vector<EvalQuery> queries = Queries(100);
  StateFocalLengths({.error = 0.1, .sigma = 0.05}, &queries);
  int num_long = 0;
  for (const EvalQuery& query : queries) {
    const double ratio = query.query.camera.focal_px() / Camera().focal_px();
    EXPECT_NEAR(ratio > 1.0 ? ratio : 1.0 / ratio, 1.1, 1e-12);
    num_long += ratio > 1.0 ? 1 : 0;
    ASSERT_TRUE(query.query.focal);
    EXPECT_EQ(query.query.focal->log_sigma, 0.05);
  }
  EXPECT_GT(num_long, 25);
  EXPECT_LT(num_long, 75);
  std::vector<EvalQuery> last = {Queries(100).back()};  // Whatever list it stands in.
  StateFocalLengths({.error = 0.1}, &last);
  EXPECT_EQ(last[0].query.camera.focal_px(), queries.back().query.camera.focal_px());
  EXPECT_FALSE(last[0].query.focal);
}

TEST(StatedFocal, MayBeWithheld) {
  std::vector<EvalQuery> queries = Queries(1);
  StateFocalLengths({.withheld = true}, &queries);
  EXPECT_EQ(queries[0].query.camera.params(), CameraOfUnknownFocal(640, 480).params());
  EXPECT_TRUE(queries[0].query.focal->with_distortion);
  EXPECT_THROW(StateFocalLengths({.error = 0.1, .withheld = true}, &queries), Error);
  EXPECT_THROW(StateFocalLengths({.error = -0.1}, &queries), Error);
  EXPECT_THROW(StateFocalLengths({.sigma = 0.0}, &queries), Error);
}

}  // namespace
}  // namespace cairn
