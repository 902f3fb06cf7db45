// Traces the camera positions that rays allow at one yaw, in cells of the accumulator.
#ifndef CAIRN_ENGINE_VOTING_TRACE_RAYS_H_
#define CAIRN_ENGINE_VOTING_TRACE_RAYS_H_

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <vector>

#include "engine/voting/ray_arrays.h"
#include "engine/voting/vote_grid.h"

namespace cairn {

// The parameters of tracing, apart from the rays, for one yaw.
struct TraceFrame {
  // The region is the vertical cylinder of `radius_m` around `center_in_anchor`, the origin of the
  // rays' positions; heights are clipped already. `min_cosine` is the cosine of the largest azimuth
  // difference.
  TraceFrame(const VoteGrid& grid, const Eigen::Vector3d& center_in_anchor, double radius_m,
             double min_cosine, double yaw_rad);

  float cos_yaw, sin_yaw, sq_radius, min_cosine;
  // A position in cells is position * scale + shift, clamped to [kLow, high] so that rounding does
  // not lead out of the accumulator.
  float scale[3], shift[3], high[3];
  static constexpr float kLow = 1.0f;
};

// Segments of camera positions; element i of each array belongs to ray i. A segment has `num_steps`
// samples. The first is at (x, y, z), and each following one is (step_x, step_y, step_z) further,
// all in cells (see VoteGrid::ToCells). A step is at most one cell along each axis. num_steps is 0
// if the ray allows no position.
struct VoteSegments {
  explicit VoteSegments(int size);

  std::vector<float> x, y, z, step_x, step_y, step_z;
  std::vector<int32_t> num_steps;
};

// Computes, for each ray including padding, the camera positions within the ray's distances and the
// region, if the azimuth of the view fits. Uses single precision: accurate to a hundredth of a cell
// up to some thousand cells along an axis. `segments` must have the rays' padded size.
void TraceRays(const RayArrays<float>& rays, const TraceFrame& frame, VoteSegments* segments);

// The arrays of VoteSegments as bare pointers; see RayPointers.
struct SegmentPointers {
  explicit SegmentPointers(VoteSegments* segments);

  float *x, *y, *z, *step_x, *step_y, *step_z;
  int32_t* num_steps;
};

// The arithmetic of TraceRays for ray i.
template <bool kHasOrigins>
[[gnu::always_inline]] inline void TraceRay(const RayPointers<float>& rays, const TraceFrame& frame,
                                            int i, const SegmentPointers& segments) {
  const auto larger = [](float a, float b) { return a > b ? a : b; };
  const auto smaller = [](float a, float b) { return a < b ? a : b; };
  const float cos_yaw = frame.cos_yaw, sin_yaw = frame.sin_yaw;
  const float dx = cos_yaw * rays.direction_x[i] - sin_yaw * rays.direction_y[i];
  const float dy = sin_yaw * rays.direction_x[i] + cos_yaw * rays.direction_y[i];
  const float dz = rays.direction_z[i];
  float x = rays.x[i], y = rays.y[i], z = rays.z[i];
  if constexpr (kHasOrigins) {
    x -= cos_yaw * rays.origin_x[i] - sin_yaw * rays.origin_y[i];
    y -= sin_yaw * rays.origin_x[i] + cos_yaw * rays.origin_y[i];
    z -= rays.origin_z[i];
  }
  // Solves |(x, y) - l (dx, dy)| <= radius. The lower bound of the slope admits vertical rays.
  const float a = larger(rays.horizontal[i] * rays.horizontal[i], 1e-12f);
  const float b = x * dx + y * dy;
  const float discriminant = b * b - a * (x * x + y * y - frame.sq_radius);
  const float root = std::sqrt(larger(discriminant, 0.0f));
  const float begin = larger(rays.min_distance_m[i], (b - root) / a);
  const float end = smaller(rays.max_distance_m[i], (b + root) / a);
  const float cosine = -(dx * rays.view_x[i] + dy * rays.view_y[i]);
  const bool is_empty =
      (discriminant < 0.0f) | (begin > end) | (cosine < frame.min_cosine * rays.horizontal[i]);

  // The comparisons map NaN into the grid, too.
  const auto to_cells = [&](float position, int axis) {
    const float cells = position * frame.scale[axis] + frame.shift[axis];
    return smaller(larger(cells, TraceFrame::kLow), frame.high[axis]);
  };
  const float first_x = to_cells(x - begin * dx, 0), last_x = to_cells(x - end * dx, 0);
  const float first_y = to_cells(y - begin * dy, 1), last_y = to_cells(y - end * dy, 1);
  const float first_z = to_cells(z - begin * dz, 2), last_z = to_cells(z - end * dz, 2);
  const float length_x = last_x - first_x, length_y = last_y - first_y, length_z = last_z - first_z;
  const float longest = larger(larger(std::abs(length_x), std::abs(length_y)), std::abs(length_z));
  const int32_t num_steps = static_cast<int32_t>(longest) + 1;
  const float share = 1.0f / static_cast<float>(num_steps);
  segments.step_x[i] = length_x * share;
  segments.step_y[i] = length_y * share;
  segments.step_z[i] = length_z * share;
  segments.x[i] = first_x + 0.5f * segments.step_x[i];
  segments.y[i] = first_y + 0.5f * segments.step_y[i];
  segments.z[i] = first_z + 0.5f * segments.step_z[i];
  segments.num_steps[i] = is_empty ? 0 : num_steps;
}

}  // namespace cairn

#endif  // CAIRN_ENGINE_VOTING_TRACE_RAYS_H_
