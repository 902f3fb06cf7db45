#include "cli/demo/street/renderer.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <span>

#include "core/check.h"

namespace cairn {
namespace {

constexpr int kSupersampling = 2;
constexpr double kNearM = 0.1;
constexpr float kSkyGray = 222.0f;
constexpr int32_t kSky = -1;
// Number of samples that share one choice of mip level.
constexpr int kRunLength = 16;

// A rectangle as seen by one camera.
struct ProjectedRect {
  // H * (x, y, 1), in sample coordinates, is (u, v, 1) / depth, with (u, v) in texels.
  Eigen::Matrix3f H;
  const Texture* texture;
  std::array<Eigen::Vector2d, 5> corners;  // Corners beyond the near plane, in samples.
  int num_corners;
};

// Clips the rectangle to z >= kNearM. Returns the number of corners: 0, 3, 4 or 5.
int ClipToNearPlane(const std::array<Eigen::Vector3d, 4>& corners_in_cam,
                    std::array<Eigen::Vector3d, 5>* clipped) {
  int num = 0;
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector3d& a = corners_in_cam[i];
    const Eigen::Vector3d& b = corners_in_cam[(i + 1) % 4];
    if (a.z() >= kNearM) {
      (*clipped)[num++] = a;
    }
    if ((a.z() >= kNearM) != (b.z() >= kNearM)) {
      (*clipped)[num++] = a + (b - a) * ((kNearM - a.z()) / (b.z() - a.z()));
    }
  }
  return num;
}

// Projects a rectangle. K maps points in the camera frame to sample coordinates. Returns false if
// the front of the rectangle is not visible.
bool ProjectRect(const TexturedRect& rect, const Rigid3d& cam_from_enu, const Eigen::Matrix3d& K,
                 const Eigen::Vector2d& num_samples, ProjectedRect* projected) {
  const Eigen::Vector3d corner = cam_from_enu * rect.corner_in_enu;
  const Eigen::Vector3d u = cam_from_enu.rotation * rect.u_in_enu;
  const Eigen::Vector3d v = cam_from_enu.rotation * rect.v_in_enu;
  // The camera center must be in front of the rectangle: on the side of v x u.
  if (-corner.dot(v.cross(u).normalized()) < 1e-4) {
    return false;
  }
  std::array<Eigen::Vector3d, 5> clipped;
  projected->num_corners =
      ClipToNearPlane({corner, corner + u, corner + u + v, corner + v}, &clipped);
  Eigen::Vector2d low = num_samples, high = Eigen::Vector2d::Zero();
  for (int i = 0; i < projected->num_corners; ++i) {
    projected->corners[i] = (K * clipped[i]).hnormalized();
    low = low.cwiseMin(projected->corners[i]);
    high = high.cwiseMax(projected->corners[i]);
  }
  if (projected->num_corners < 3 || low.x() >= num_samples.x() || low.y() >= num_samples.y() ||
      high.x() <= 0.0 || high.y() <= 0.0) {
    return false;
  }
  // A point of the plane is corner + s u + t v; [u v corner] (s, t, 1) = depth * K^-1 (x, y, 1).
  Eigen::Matrix3d plane;
  plane << u / rect.texture->width(), v / rect.texture->height(), corner;
  projected->H = (plane.inverse() * K.inverse()).cast<float>();
  projected->texture = rect.texture.get();
  return true;
}

// Returns the samples [first, last) of row y (center y + 0.5) inside the convex polygon.
std::pair<int, int> RowSpan(const ProjectedRect& rect, int y, int num_columns) {
  const double center_y = y + 0.5;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (int i = 0; i < rect.num_corners; ++i) {
    const Eigen::Vector2d& a = rect.corners[i];
    const Eigen::Vector2d& b = rect.corners[i + 1 == rect.num_corners ? 0 : i + 1];
    if ((a.y() <= center_y) != (b.y() <= center_y)) {
      const double x = a.x() + (b.x() - a.x()) * ((center_y - a.y()) / (b.y() - a.y()));
      low = std::min(low, x);
      high = std::max(high, x);
    }
  }
  if (low > high) {
    return {0, 0};
  }
  const double max_x = num_columns;
  return {static_cast<int>(std::ceil(std::clamp(low - 0.5, 0.0, max_x))),
          static_cast<int>(std::ceil(std::clamp(high - 0.5, 0.0, max_x)))};
}

// Finds the nearest rectangle at each sample of one row.
void FindVisible(std::span<const ProjectedRect> rects, std::span<const int> active, int y,
                 std::span<float> inverse_depth, std::span<int32_t> visible) {
  std::fill(inverse_depth.begin(), inverse_depth.end(), 0.0f);
  std::fill(visible.begin(), visible.end(), kSky);
  for (const int idx : active) {
    const ProjectedRect& rect = rects[idx];
    const auto [first, last] = RowSpan(rect, y, static_cast<int>(visible.size()));
    const float slope = rect.H(2, 0);
    const float start = rect.H(2, 1) * (y + 0.5f) + rect.H(2, 2) + 0.5f * slope;
    for (int x = first; x < last; ++x) {
      const float w = start + slope * static_cast<float>(x);
      const bool nearer = w > inverse_depth[x];
      inverse_depth[x] = nearer ? w : inverse_depth[x];
      visible[x] = nearer ? idx : visible[x];
    }
  }
}

// Adds the gray values of the samples [first, last) of row y to `sums`. All of these samples show
// `rect`.
void ShadeRun(const ProjectedRect& rect, int y, int first, int last, std::span<float> sums) {
  const Eigen::Matrix3f& H = rect.H;
  const Eigen::Vector3f start = H.col(1) * (y + 0.5f) + H.col(2);
  const Eigen::Vector3f middle = start + H.col(0) * (0.5f * static_cast<float>(first + last));
  // d(u, v)/d(x, y) by the quotient rule: the number of texels that a sample covers.
  const Eigen::Vector2f uv = middle.hnormalized();
  const Eigen::Vector2f d_dx = (H.col(0).head<2>() - uv * H(2, 0)) / middle.z();
  const Eigen::Vector2f d_dy = (H.col(1).head<2>() - uv * H(2, 1)) / middle.z();
  const Eigen::Vector2f extent = d_dx.cwiseAbs().cwiseMax(d_dy.cwiseAbs());
  const Texture::Level level = rect.texture->LevelFor(extent.x(), extent.y());
  for (int x = first; x < last; ++x) {
    const float center_x = static_cast<float>(x) + 0.5f;
    const float depth = 1.0f / (start.z() + H(2, 0) * center_x);
    sums[x / kSupersampling] += level.Sample((start.x() + H(0, 0) * center_x) * depth,
                                             (start.y() + H(1, 0) * center_x) * depth);
  }
}

void ShadeRow(std::span<const ProjectedRect> rects, std::span<const int32_t> visible, int y,
              std::span<float> sums) {
  const int num_columns = static_cast<int>(visible.size());
  for (int first = 0; first < num_columns;) {
    int last = first + 1;
    while (last < num_columns && last - first < kRunLength && visible[last] == visible[first]) {
      ++last;
    }
    if (visible[first] == kSky) {
      for (int x = first; x < last; ++x) {
        sums[x / kSupersampling] += kSkyGray;
      }
    } else {
      ShadeRun(rects[visible[first]], y, first, last, sums);
    }
    first = last;
  }
}

// Standard normal numbers, drawn once. A photo's noise reads them from random positions.
const std::vector<float>& NormalTable() {
  static const std::vector<float> table = [] {
    std::mt19937_64 rng(20220725);
    std::normal_distribution<float> normal;
    std::vector<float> numbers(1 << 16);
    std::generate(numbers.begin(), numbers.end(), [&] { return normal(rng); });
    return numbers;
  }();
  return table;
}

// Converts light to gray levels: exposure, vignetting by the squared distance to the image center
// (1 at the corners), noise, rounding.
void ExposeRow(const PhotoEffects& effects, int y, std::mt19937_64* rng,
               std::span<const float> light, GrayImage* image) {
  const std::vector<float>& normals = NormalTable();
  const size_t noise_start = (*rng)() % (normals.size() - light.size());
  const double half_width = 0.5 * image->width_px, half_height = 0.5 * image->height_px;
  const double sq_corner = half_width * half_width + half_height * half_height;
  const double sq_dy = std::pow(y + 0.5 - half_height, 2);
  const float gain = static_cast<float>(effects.gain);
  const float sigma = static_cast<float>(effects.noise_sigma);
  const float falloff = static_cast<float>(effects.vignetting / sq_corner);
  uint8_t* out = image->pixels.data() + static_cast<size_t>(y) * image->width_px;
  for (size_t x = 0; x < light.size(); ++x) {
    const float dx = static_cast<float>(static_cast<double>(x) + 0.5 - half_width);
    const float sq_radius = dx * dx + static_cast<float>(sq_dy);
    const float gray =
        light[x] * gain * (1.0f - falloff * sq_radius) + sigma * normals[noise_start + x];
    out[x] = static_cast<uint8_t>(std::clamp(gray + 0.5f, 0.0f, 255.0f));
  }
}

std::vector<ProjectedRect> ProjectAll(const std::vector<TexturedRect>& rects, const Camera& camera,
                                      const Rigid3d& cam_from_enu) {
  const std::vector<double>& params = camera.params();
  Eigen::Matrix3d K;
  K << params[0], 0.0, params[2], 0.0, params[1], params[3], 0.0, 0.0, 1.0 / kSupersampling;
  K *= kSupersampling;
  const Eigen::Vector2d num_samples(camera.width_px() * kSupersampling,
                                    camera.height_px() * kSupersampling);
  std::vector<ProjectedRect> projected;
  ProjectedRect one;
  for (const TexturedRect& rect : rects) {
    if (ProjectRect(rect, cam_from_enu, K, num_samples, &one)) {
      projected.push_back(one);
    }
  }
  return projected;
}

// Lists, for each row of samples, the rectangles that may touch the row.
std::vector<std::vector<int>> ActiveByRow(std::span<const ProjectedRect> rects, int num_rows) {
  std::vector<std::vector<int>> active(num_rows);
  for (size_t idx = 0; idx < rects.size(); ++idx) {
    double low = num_rows, high = 0.0;
    for (int i = 0; i < rects[idx].num_corners; ++i) {
      low = std::min(low, rects[idx].corners[i].y());
      high = std::max(high, rects[idx].corners[i].y());
    }
    const int last = static_cast<int>(std::min<double>(num_rows, std::ceil(high)));
    for (int y = static_cast<int>(std::max(0.0, std::floor(low))); y < last; ++y) {
      active[y].push_back(static_cast<int>(idx));
    }
  }
  return active;
}

}  // namespace

GrayImage Renderer::Render(const Camera& camera, const Rigid3d& cam_from_enu,
                           const PhotoEffects& effects) const {
  CAIRN_CHECK(camera.model() == CameraModel::kPinhole, "the renderer has no lens distortion");
  GrayImage image;
  image.width_px = camera.width_px();
  image.height_px = camera.height_px();
  image.pixels.resize(static_cast<size_t>(image.width_px) * image.height_px);

  const std::vector<ProjectedRect> rects = ProjectAll(rects_, camera, cam_from_enu);
  const int num_columns = image.width_px * kSupersampling;
  const auto active = ActiveByRow(rects, image.height_px * kSupersampling);
  std::vector<float> inverse_depth(num_columns), light(image.width_px);
  std::vector<int32_t> visible(num_columns);
  std::mt19937_64 rng(effects.noise_seed);
  for (int row = 0; row < image.height_px; ++row) {
    std::fill(light.begin(), light.end(), 0.0f);
    for (int y = row * kSupersampling; y < (row + 1) * kSupersampling; ++y) {
      FindVisible(rects, active[y], y, inverse_depth, visible);
      ShadeRow(rects, visible, y, light);
    }
    for (float& value : light) {
      value /= kSupersampling * kSupersampling;
    }
    ExposeRow(effects, row, &rng, light, &image);
  }
  return image;
}

double Renderer::FreeSightM(const Eigen::Vector3d& origin_in_enu,
                            const Eigen::Vector3d& direction_in_enu) const {
  double free_m = std::numeric_limits<double>::infinity();
  for (const TexturedRect& rect : rects_) {
    const Eigen::Vector3d normal = rect.v_in_enu.cross(rect.u_in_enu);
    const double approach = -direction_in_enu.dot(normal);
    if (approach <= 0.0) {
      continue;  // Seen from behind or edge-on.
    }
    const Eigen::Vector3d offset = origin_in_enu - rect.corner_in_enu;
    const double distance_m = offset.dot(normal) / approach;
    const Eigen::Vector3d hit = offset + distance_m * direction_in_enu;
    const double u = hit.dot(rect.u_in_enu) / rect.u_in_enu.squaredNorm();
    const double v = hit.dot(rect.v_in_enu) / rect.v_in_enu.squaredNorm();
    if (distance_m > 0.0 && u >= 0.0 && u <= 1.0 && v >= 0.0 && v <= 1.0) {
      free_m = std::min(free_m, distance_m);
    }
  }
  return free_m;
}

}  // namespace cairn
