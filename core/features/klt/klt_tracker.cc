#include "core/features/klt/klt_tracker.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/require.h"

namespace cairn::fusion {
namespace {

// In OpenCV, the center of the upper left pixel is at (0, 0).
constexpr double kPixelCenter = 0.5;
// Number of corners to detect per wanted feature. The surplus lets every cell find some.
constexpr int kCornersPerFeature = 8;
// New corners fill the cells of this grid evenly. Features then cover the whole image even if most
// of the texture is in one part of it.
constexpr int kGridColumns = 8;
constexpr int kGridRows = 6;
constexpr double kMinDistancePx = 10.0;  // Smallest distance between two features.
// Least quality of a new corner: the smaller eigenvalue of the gradient's structure tensor,
// relative to that of the best corner. The limit is low because dim cells need corners, too;
// tracking removes the bad ones.
constexpr double kMinRelativeQuality = 0.003;
// Pyramid levels. Covers motions up to about 2^kNumLevels * window_px / 4.
constexpr int kNumLevels = 4;
constexpr int kMaxIterations = 30;
// A feature is tracked to the new image and back. The feature is kept only if it returns to within
// this distance of its start.
constexpr double kMaxForwardBackwardPx = 0.5;
constexpr int kBorderPx = 4;  // Features nearer to the image edge are dropped.

}  // namespace

void KltOptions::Validate() const {
  RequireOption(max_features >= 1, "klt.max_features must be positive");
  RequireOption(window_px >= 5 && window_px % 2 == 1, "klt.window_px must be odd and at least 5");
}

struct KltTracker::Impl {
  explicit Impl(const KltOptions& klt_options) : options(klt_options) {}

  void TrackExisting() {
    if (points.empty()) {
      return;
    }
    std::vector<cv::Point2f> found, back = points;
    std::vector<uint8_t> is_found, is_back;
    std::vector<float> errors;
    const cv::Size window(options.window_px, options.window_px);
    const cv::TermCriteria stop(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, kMaxIterations,
                                0.01);
    cv::calcOpticalFlowPyrLK(last_pyramid, pyramid, points, found, is_found, errors, window,
                             kNumLevels - 1, stop);
    cv::calcOpticalFlowPyrLK(pyramid, last_pyramid, found, back, is_back, errors, window,
                             kNumLevels - 1, stop, cv::OPTFLOW_USE_INITIAL_FLOW);
    size_t num_kept = 0;
    for (size_t i = 0; i < points.size(); ++i) {
      const bool returns =
          is_found[i] && is_back[i] && cv::norm(back[i] - points[i]) < kMaxForwardBackwardPx;
      if (returns && IsInside(found[i]) && IsFree(found[i])) {
        Occupy(found[i]);
        ids[num_kept] = ids[i];
        points[num_kept++] = found[i];
      }
    }
    ids.resize(num_kept);
    points.resize(num_kept);
  }

  void AddCorners() {
    const int num_wanted = options.max_features - static_cast<int>(points.size());
    if (num_wanted <= 0) {
      return;
    }
    std::vector<cv::Point2f> corners;  // Best first.
    cv::goodFeaturesToTrack(image, corners, kCornersPerFeature * options.max_features,
                            kMinRelativeQuality, kMinDistancePx, free);
    std::vector<int> num_in_cell(static_cast<size_t>(kGridColumns) * static_cast<size_t>(kGridRows),
                                 0);
    for (const cv::Point2f& point : points) {
      ++num_in_cell[CellOf(point)];
    }
    // Raises every cell to one feature, then to two, and so on. Each cell takes its best corners
    // first.
    std::vector<std::vector<cv::Point2f>> corners_of_cell(num_in_cell.size());
    for (auto corner = corners.rbegin(); corner != corners.rend(); ++corner) {
      if (IsInside(*corner)) {
        corners_of_cell[CellOf(*corner)].push_back(*corner);  // Ascending quality.
      }
    }
    int num_left = num_wanted;
    for (int level = 1; level <= options.max_features && num_left > 0; ++level) {
      for (size_t cell = 0; cell < num_in_cell.size() && num_left > 0; ++cell) {
        if (num_in_cell[cell] < level && !corners_of_cell[cell].empty()) {
          points.push_back(corners_of_cell[cell].back());
          ids.push_back(next_id++);
          corners_of_cell[cell].pop_back();
          ++num_in_cell[cell];
          --num_left;
        }
      }
    }
  }

  bool IsInside(const cv::Point2f& point) const {
    const auto border = static_cast<float>(kBorderPx);
    return point.x >= border && point.y >= border &&
           point.x <= static_cast<float>(image.cols - 1) - border &&
           point.y <= static_cast<float>(image.rows - 1) - border;
  }
  bool IsFree(const cv::Point2f& point) const { return free.at<uint8_t>(cv::Point(point)) != 0; }
  void Occupy(const cv::Point2f& point) {
    cv::circle(free, point, static_cast<int>(kMinDistancePx), 0, cv::FILLED);
  }
  size_t CellOf(const cv::Point2f& point) const {
    const int column = static_cast<int>(point.x) * kGridColumns / image.cols;
    const int row = static_cast<int>(point.y) * kGridRows / image.rows;
    return static_cast<size_t>(row * kGridColumns + column);
  }

  KltOptions options;
  cv::Mat image;
  cv::Mat free;  // Zero near features.
  std::vector<cv::Mat> pyramid, last_pyramid;
  std::vector<cv::Point2f> points;
  std::vector<uint64_t> ids;  // Parallel to points.
  uint64_t next_id = 1;
  std::vector<TrackedFeature> features;
};

KltTracker::KltTracker(const KltOptions& options) {
  options.Validate();
  impl_ = std::make_unique<Impl>(options);
}

KltTracker::~KltTracker() = default;

void KltTracker::Reset() {
  impl_->points.clear();
  impl_->ids.clear();
}

std::span<const TrackedFeature> KltTracker::Track(const GrayView& view) {
  Impl& impl = *impl_;
  const int min_side = 2 * kBorderPx + impl.options.window_px;
  if (view.pixels == nullptr || view.width_px < min_side || view.height_px < min_side ||
      view.stride_bytes < view.width_px) {
    throw Error(ErrorCode::kBadInput,
                "KltTracker: an image must have at least " + std::to_string(min_side) +
                    " pixels a side, and rows at least as far apart as they are long");
  }
  if (impl.image.cols != view.width_px || impl.image.rows != view.height_px) {
    Reset();
  }
  // OpenCV has no view of constant pixels. The pixels are only read.
  cv::Mat(view.height_px, view.width_px, CV_8UC1, const_cast<uint8_t*>(view.pixels),
          static_cast<size_t>(view.stride_bytes))
      .copyTo(impl.image);
  impl.free = cv::Mat(impl.image.size(), CV_8UC1, cv::Scalar(255));
  std::swap(impl.pyramid, impl.last_pyramid);
  cv::buildOpticalFlowPyramid(impl.image, impl.pyramid,
                              cv::Size(impl.options.window_px, impl.options.window_px),
                              kNumLevels - 1);
  impl.TrackExisting();
  impl.AddCorners();
  impl.features.clear();
  for (size_t i = 0; i < impl.points.size(); ++i) {
    impl.features.push_back(
        {impl.ids[i], {impl.points[i].x + kPixelCenter, impl.points[i].y + kPixelCenter}});
  }
  return impl.features;
}

}  // namespace cairn::fusion
