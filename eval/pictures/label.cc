#include "eval/pictures/label.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/file_bytes.h"
#include "core/images/encode_image.h"
#include "eval/pictures/picture_format.h"

namespace cairn {
namespace {

constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
constexpr int kJpegQuality = 90;           // Text stays crisp.
constexpr double kCapitalHeightPx = 21.0;  // Of OpenCV's font at scale 1.

double FontScale(double height_px) { return height_px / kCapitalHeightPx; }

int Thickness(double height_px) { return height_px >= 16.0 ? 2 : 1; }

}  // namespace

int LabelWidthPx(const std::string& text, double height_px) {
  int base_line = 0;
  return cv::getTextSize(text, kFont, FontScale(height_px), Thickness(height_px), &base_line).width;
}

void DrawLabel(const std::string& text, cv::Point at, double height_px, const cv::Scalar& color,
               LabelAnchor anchor, bool halo, cv::Mat* image) {
  const int width = LabelWidthPx(text, height_px);
  at.x -= anchor == LabelAnchor::kRight ? width : anchor == LabelAnchor::kCenter ? width / 2 : 0;
  if (halo) {
    cv::putText(*image, text, at, kFont, FontScale(height_px), kPaper, Thickness(height_px) + 3,
                cv::LINE_AA);
  }
  cv::putText(*image, text, at, kFont, FontScale(height_px), color, Thickness(height_px),
              cv::LINE_AA);
}

cv::Scalar ColorOf(double share) {
  static const cv::Mat table = [] {
    cv::Mat ramp(1, 256, CV_8UC1), colors;
    for (int i = 0; i < 256; ++i) {
      ramp.at<uint8_t>(0, i) = static_cast<uint8_t>(i);
    }
    cv::applyColorMap(ramp, colors, cv::COLORMAP_TURBO);
    return colors;
  }();
  // The ends of the color map are too dark to distinguish.
  const double inner = 0.08 + 0.84 * std::clamp(share, 0.0, 1.0);
  const auto color = table.at<cv::Vec3b>(0, static_cast<int>(255.0 * inner));
  return {static_cast<double>(color[0]), static_cast<double>(color[1]),
          static_cast<double>(color[2])};
}

void DrawColorBar(const cv::Rect& bar, const std::vector<std::string>& labels, double height_px,
                  cv::Mat* image) {
  for (int y = 0; y < bar.height; ++y) {
    const double share = 1.0 - (y + 0.5) / bar.height;
    cv::line(*image, {bar.x, bar.y + y}, {bar.x + bar.width - 1, bar.y + y}, ColorOf(share));
  }
  cv::rectangle(*image, bar, kInk, 1, cv::LINE_AA);
  for (size_t i = 0; i < labels.size(); ++i) {
    const double share = labels.size() < 2 ? 0.0 : static_cast<double>(i) / (labels.size() - 1);
    const int y = bar.y + static_cast<int>(std::lround((1.0 - share) * (bar.height - 1)));
    cv::line(*image, {bar.x + bar.width, y}, {bar.x + bar.width + 5, y}, kInk, 1, cv::LINE_AA);
    DrawLabel(labels[i], {bar.x + bar.width + 10, y + static_cast<int>(0.5 * height_px)}, height_px,
              kInk, LabelAnchor::kLeft, false, image);
  }
}

std::vector<uint8_t> EncodePicture(const std::string& extension, const cv::Mat& image) {
  const PictureRows rows = {.width_px = image.cols,
                            .height_px = image.rows,
                            .num_channels = image.channels(),
                            .pixels = image.data,
                            .row_bytes = image.step[0]};
  if (extension == ".png") {
    return EncodePng(rows);
  }
  return extension == ".ppm" ? EncodePnm(rows) : EncodeJpeg(rows, kJpegQuality);
}

void WritePicture(const std::string& path, const cv::Mat& image) {
  WriteFileBytes(path, EncodePicture(PictureExtension(path), image));
}

}  // namespace cairn
