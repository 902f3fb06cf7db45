#include "engine/voting/trace_rays.h"

#include "core/simd.h"

namespace cairn {
namespace {

// The iterations are independent, since outputs and inputs are different arrays.
CAIRN_VECTOR_CLONES
void TraceWithOrigins(const RayPointers<float> rays, const TraceFrame frame, int size,
                      const SegmentPointers segments) {
#pragma GCC ivdep
  for (int i = 0; i < size; ++i) {
    TraceRay<true>(rays, frame, i, segments);
  }
}

CAIRN_VECTOR_CLONES
void TraceWithoutOrigins(const RayPointers<float> rays, const TraceFrame frame, int size,
                         const SegmentPointers segments) {
#pragma GCC ivdep
  for (int i = 0; i < size; ++i) {
    TraceRay<false>(rays, frame, i, segments);
  }
}

}  // namespace

TraceFrame::TraceFrame(const VoteGrid& grid, const Eigen::Vector3d& center_in_anchor,
                       double radius_m, double min_azimuth_cosine, double yaw_rad)
    : cos_yaw(static_cast<float>(std::cos(yaw_rad))),
      sin_yaw(static_cast<float>(std::sin(yaw_rad))),
      sq_radius(static_cast<float>(radius_m * radius_m)),
      min_cosine(static_cast<float>(min_azimuth_cosine)) {
  const Eigen::Vector3d center_in_cells = grid.ToCells(center_in_anchor);
  for (int axis = 0; axis < 3; ++axis) {
    scale[axis] = static_cast<float>(1.0 / grid.cell_m()[axis]);
    shift[axis] = static_cast<float>(center_in_cells[axis]);
    high[axis] = std::nextafter(static_cast<float>(grid.size()[axis] - 1), 0.0f);
  }
}

VoteSegments::VoteSegments(int size)
    : x(size), y(size), z(size), step_x(size), step_y(size), step_z(size), num_steps(size) {}

SegmentPointers::SegmentPointers(VoteSegments* segments)
    : x(segments->x.data()),
      y(segments->y.data()),
      z(segments->z.data()),
      step_x(segments->step_x.data()),
      step_y(segments->step_y.data()),
      step_z(segments->step_z.data()),
      num_steps(segments->num_steps.data()) {}

void TraceRays(const RayArrays<float>& rays, const TraceFrame& frame, VoteSegments* segments) {
  (rays.has_origins() ? TraceWithOrigins : TraceWithoutOrigins)(
      RayPointers(rays), frame, rays.padded_size(), SegmentPointers(segments));
}

}  // namespace cairn
