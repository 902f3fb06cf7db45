#include "engine/voting/trace_rays.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "core/angles.h"

namespace cairn {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Cells of 1 m, so that lengths are numbers of cells.
VoteGrid MeterGrid() { return VoteGrid({-100, -100, -10}, {100, 100, 10}, {1, 1, 1}); }

// A ray to the east, seen by the map from the west.
VoteRay EastwardRay() {
  VoteRay ray;
  ray.x_in_anchor = {10, 0, 0};
  ray.direction_in_level = Vector3d::UnitX();
  ray.horizontal = 1.0;
  ray.view_azimuth = {-1, 0};
  ray.min_distance_m = 0.0;
  ray.max_distance_m = 100.0;
  return ray;
}

// A segment of positions in the anchor frame.
struct Segment {
  int num_steps = 0;
  Vector3d begin, end;
};

Segment SegmentAt(const VoteSegments& s, int i, const VoteGrid& grid) {
  const Vector3d first(s.x[i], s.y[i], s.z[i]), step(s.step_x[i], s.step_y[i], s.step_z[i]);
  return {s.num_steps[i], grid.FromCells(first - 0.5 * step),
          grid.FromCells(first + (s.num_steps[i] - 0.5) * step)};
}

Segment Trace(const VoteRay& ray, double yaw_rad, const Vector2d& center, double radius_m,
              double min_cosine) {
  const VoteGrid grid = MeterGrid();
  const Vector3d center_in_anchor(center.x(), center.y(), 1.0);
  const RayArrays<float> rays({ray}, center_in_anchor);
  VoteSegments segments(rays.padded_size());
  TraceRays(rays, TraceFrame(grid, center_in_anchor, radius_m, min_cosine, yaw_rad), &segments);
  return SegmentAt(segments, 0, grid);
}

TEST(TraceRays, KeepsThePartWithinTheRegion) {
  const Segment segment = Trace(EastwardRay(), 0.0, {0, 3}, 5.0, -1.0);
  EXPECT_EQ(segment.num_steps, 9);                               // At most a cell each.
  EXPECT_TRUE(segment.begin.isApprox(Vector3d(4, 0, 0), 1e-4));  // 4^2 + 3^2 = 5^2.
  EXPECT_TRUE(segment.end.isApprox(Vector3d(-4, 0, 0), 1e-4));
}

TEST(TraceRays, KeepsThePartWithinTheDistances) {
  VoteRay ray = EastwardRay();
  ray.min_distance_m = 2.5;
  ray.max_distance_m = 7.25;
  const Segment segment = Trace(ray, 0.0, {0, 0}, 100.0, -1.0);
  EXPECT_TRUE(segment.begin.isApprox(Vector3d(7.5, 0, 0), 1e-4));
  EXPECT_TRUE(segment.end.isApprox(Vector3d(2.75, 0, 0), 1e-4));
}

TEST(TraceRays, NothingIfTheRayMissesOrStartsBeyond) {
  EXPECT_EQ(Trace(EastwardRay(), 0.0, {0, 6}, 5.0, -1.0).num_steps, 0);
  // The camera would stand east of the landmark, the region is in the west.
  EXPECT_EQ(Trace(EastwardRay(), kPi, {0, 0}, 5.0, -1.0).num_steps, 0);
}

TEST(TraceRays, AzimuthDecides) {
  const double cosine = std::cos(1.0);
  EXPECT_GT(Trace(EastwardRay(), 0.9, {0, 0}, 100.0, cosine).num_steps, 0);
  EXPECT_EQ(Trace(EastwardRay(), 1.1, {0, 0}, 100.0, cosine).num_steps, 0);
}

TEST(TraceRays, VerticalRayStaysWhereItIs) {
  VoteRay ray = EastwardRay();
  ray.direction_in_level = Vector3d::UnitZ();
  ray.horizontal = 0.0;
  ray.max_distance_m = 8.0;
  const Segment segment = Trace(ray, 1.0, {10, 0}, 1.0, -1.0);
  EXPECT_TRUE(segment.begin.isApprox(Vector3d(10, 0, 0), 1e-4));
  EXPECT_TRUE(segment.end.isApprox(Vector3d(10, 0, -8), 1e-4));
  EXPECT_EQ(Trace(ray, 1.0, {20, 0}, 1.0, -1.0).num_steps, 0);
}

TEST(TraceRays, PaddingHasNoSteps) {
  const RayArrays<float> rays({EastwardRay()}, Vector3d::Zero());
  VoteSegments segments(rays.padded_size());
  TraceRays(rays, TraceFrame(MeterGrid(), Vector3d::Zero(), 50.0, -1.0, 0.0), &segments);
  ASSERT_EQ(rays.padded_size(), 16);
  EXPECT_GT(segments.num_steps[0], 0);
  for (int i = 1; i < rays.padded_size(); ++i) {
    EXPECT_EQ(segments.num_steps[i], 0);
  }
}

// Rays all over a region of 100 m.
std::vector<VoteRay> RandomRays(int count, bool has_origins) {
  std::mt19937 engine(3);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::vector<VoteRay> rays;
  for (int i = 0; i < count; ++i) {
    VoteRay ray;
    ray.x_in_anchor = {150 * uniform(engine), 150 * uniform(engine), 2 * uniform(engine)};
    const double heading_rad = kPi * uniform(engine);
    ray.direction_in_level =
        Vector3d(std::cos(heading_rad), std::sin(heading_rad), 0.1 * uniform(engine)).normalized();
    ray.horizontal = ray.direction_in_level.head<2>().norm();
    const double azimuth_rad = kPi * uniform(engine);
    ray.view_azimuth = {std::cos(azimuth_rad), std::sin(azimuth_rad)};
    ray.min_distance_m = 1.0 + 10.0 * std::abs(uniform(engine));
    ray.max_distance_m = 5.0 + 40.0 * std::abs(uniform(engine));
    if (has_origins) {
      ray.origin_in_level = 3.0 * Vector3d(uniform(engine), uniform(engine), uniform(engine));
    }
    rays.push_back(ray);
  }
  return rays;
}

// Walks along each ray in small steps: what fits, and nothing else, must be on the segment.
void ExpectTheDefinition(bool has_origins) {
  constexpr double kRadiusM = 100.0, kYawRad = 0.7, kStepM = 0.05, kToleranceM = 0.02;
  const double min_cosine = std::cos(1.3);
  const VoteGrid grid = MeterGrid();
  const std::vector<VoteRay> all = RandomRays(500, has_origins);
  const RayArrays<float> rays(all, Vector3d::Zero());
  VoteSegments segments(rays.padded_size());
  TraceRays(rays, TraceFrame(grid, Vector3d::Zero(), kRadiusM, min_cosine, kYawRad), &segments);
  const Eigen::AngleAxisd turn(kYawRad, Vector3d::UnitZ());
  int num_traced = 0;
  for (size_t i = 0; i < all.size(); ++i) {
    const VoteRay& ray = all[i];
    const Vector3d direction = turn * ray.direction_in_level;
    const bool azimuth_fits = -direction.head<2>().normalized().dot(ray.view_azimuth) >= min_cosine;
    const auto center = [&](double distance_m) -> Vector3d {
      return ray.x_in_anchor - turn * ray.origin_in_level - distance_m * direction;
    };
    double begin_m = std::numeric_limits<double>::infinity(), end_m = -begin_m;
    for (double l = ray.min_distance_m; azimuth_fits && l <= ray.max_distance_m; l += kStepM) {
      if (center(l).head<2>().norm() <= kRadiusM) {
        begin_m = std::min(begin_m, l);
        end_m = std::max(end_m, l);
      }
    }
    const Segment segment = SegmentAt(segments, static_cast<int>(i), grid);
    if (begin_m > end_m) {
      EXPECT_LE(segment.num_steps, 1);  // Too short to be found in steps.
      continue;
    }
    ++num_traced;
    EXPECT_LT((segment.begin - center(begin_m)).norm(), kStepM + kToleranceM);
    EXPECT_LT((segment.end - center(end_m)).norm(), kStepM + kToleranceM);
    EXPECT_LE((segment.end - segment.begin).cwiseAbs().maxCoeff(), segment.num_steps);
  }
  EXPECT_GT(num_traced, 50);
}

TEST(TraceRays, FollowsTheDefinition) { ExpectTheDefinition(false); }
TEST(TraceRays, FollowsTheDefinitionOfARig) { ExpectTheDefinition(true); }

template <bool kHasOrigins>
void ExpectVectorsEqualOneByOne() {
  const VoteGrid grid = MeterGrid();
  RayArrays<float> rays(RandomRays(1001, kHasOrigins), Vector3d::Zero());
  VoteSegments together(rays.padded_size()), alone(rays.padded_size());
  const TraceFrame frame(grid, Vector3d::Zero(), 100.0, std::cos(1.3), 2.1);
  TraceRays(rays, frame, &together);
  for (int i = 0; i < rays.padded_size(); ++i) {
    TraceRay<kHasOrigins>(RayPointers(rays), frame, i, SegmentPointers(&alone));
  }
  // Fused multiplications may move an end by the last bits.
  for (int i = 0; i < rays.padded_size(); ++i) {
    const Segment a = SegmentAt(together, i, grid), b = SegmentAt(alone, i, grid);
    ASSERT_EQ(a.num_steps > 0, b.num_steps > 0);
    if (a.num_steps > 0) {
      EXPECT_NEAR(a.num_steps, b.num_steps, 1);
      EXPECT_LT((a.begin - b.begin).norm(), 1e-3);
      EXPECT_LT((a.end - b.end).norm(), 1e-3);
    }
  }
}

TEST(TraceRays, ManyAtOnceAreAsOneByOne) { ExpectVectorsEqualOneByOne<false>(); }
TEST(TraceRays, ManyAtOnceAreAsOneByOneForARig) { ExpectVectorsEqualOneByOne<true>(); }

TEST(TraceRays, NothingLeadsOutOfTheGrid) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const VoteGrid grid({-10, -10, -10}, {10, 10, 10}, {2, 2, 2});
  std::vector<VoteRay> all = RandomRays(200, false);
  for (size_t i = 0; i < all.size(); ++i) {
    all[i].x_in_anchor *= std::pow(10.0, static_cast<double>(i % 12));
    all[i].max_distance_m = i % 5 == 0 ? kInfinity : 1e7;
    all[i].min_distance_m = i % 7 == 0 ? -kInfinity : 0.0;
    if (i % 11 == 0) {
      all[i].x_in_anchor.x() = std::nan("");
    }
  }
  const RayArrays<float> rays(all, Vector3d::Zero());
  VoteSegments segments(rays.padded_size());
  TraceRays(rays, TraceFrame(grid, Vector3d::Zero(), 1e9, -2.0, 0.3), &segments);
  int num_traced = 0;
  for (int i = 0; i < rays.padded_size(); ++i) {
    num_traced += segments.num_steps[i] > 0;
    for (const int step : {0, segments.num_steps[i] - 1}) {
      const auto cell = [step](float first, float by) {
        return static_cast<int>(first + static_cast<float>(step) * by);
      };
      if (segments.num_steps[i] > 0) {
        for (const int c :
             {cell(segments.x[i], segments.step_x[i]), cell(segments.y[i], segments.step_y[i]),
              cell(segments.z[i], segments.step_z[i])}) {
          EXPECT_GE(c, 0);
          EXPECT_LT(c, grid.size()[0]);
        }
      }
    }
  }
  EXPECT_GT(num_traced, 20);
}

}  // namespace
}  // namespace cairn
