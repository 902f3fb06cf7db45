#include "cli/demo/street/canvas.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace cairn {
namespace {

int NumTexels(double length_m, double texels_per_m) {
  const int steps = static_cast<int>(std::ceil(length_m * texels_per_m / Texture::kSizeStep));
  return std::max(steps, 1) * Texture::kSizeStep;
}

}  // namespace

Canvas::Canvas(double width_m, double height_m, double texels_per_m, double gray)
    : width_m_(width_m),
      height_m_(height_m),
      pixels_(NumTexels(height_m, texels_per_m), NumTexels(width_m, texels_per_m), CV_8UC1,
              cv::Scalar(gray)) {
  x_texels_per_m_ = pixels_.cols / width_m;
  z_texels_per_m_ = pixels_.rows / height_m;
}

int Canvas::Column(double x_m) const {
  return static_cast<int>(std::lround(x_m * x_texels_per_m_));
}

int Canvas::Row(double z_m) const {
  return static_cast<int>(std::lround((height_m_ - z_m) * z_texels_per_m_));
}

void Canvas::FillRect(double x_m, double z_m, double width_m, double height_m, double gray) {
  const cv::Rect rect(cv::Point(Column(x_m), Row(z_m + height_m)),
                      cv::Point(Column(x_m + width_m), Row(z_m)));
  pixels_(rect & cv::Rect(0, 0, pixels_.cols, pixels_.rows)).setTo(cv::Scalar(gray));
}

void Canvas::FillEllipse(double x_m, double z_m, double x_radius_m, double z_radius_m,
                         double gray) {
  const cv::Size axes(std::max(1, static_cast<int>(x_radius_m * x_texels_per_m_)),
                      std::max(1, static_cast<int>(z_radius_m * z_texels_per_m_)));
  cv::ellipse(pixels_, cv::Point(Column(x_m), Row(z_m)), axes, 0.0, 0.0, 360.0, cv::Scalar(gray),
              cv::FILLED, cv::LINE_AA);
}

void Canvas::Line(double x0_m, double z0_m, double x1_m, double z1_m, double thickness_m,
                  double gray) {
  const int thickness = std::max(1, static_cast<int>(std::lround(thickness_m * z_texels_per_m_)));
  cv::line(pixels_, cv::Point(Column(x0_m), Row(z0_m)), cv::Point(Column(x1_m), Row(z1_m)),
           cv::Scalar(gray), thickness, cv::LINE_AA);
}

void Canvas::Text(double x_m, double z_m, double height_m, double max_width_m,
                  const std::string& text, double gray) {
  constexpr int kFont = cv::FONT_HERSHEY_DUPLEX;
  constexpr double kCapitalHeight = 21.0;  // Texels at font scale 1.
  int base_line = 0;
  const double unit_width = cv::getTextSize(text, kFont, 1.0, 2, &base_line).width;
  const double scale = std::min(height_m * z_texels_per_m_ / kCapitalHeight,
                                max_width_m * x_texels_per_m_ / std::max(unit_width, 1.0));
  const int thickness = std::max(1, static_cast<int>(std::lround(3.0 * scale)));
  cv::putText(pixels_, text, cv::Point(Column(x_m), Row(z_m)), kFont, scale, cv::Scalar(gray),
              thickness, cv::LINE_AA);
}

void Canvas::AddPatches(cv::RNG* rng, double patch_m, double amplitude) {
  AddNoise(rng, patch_m, patch_m, amplitude);
}

void Canvas::AddStreaks(cv::RNG* rng, double width_m, double height_m, double amplitude) {
  AddNoise(rng, width_m, height_m, amplitude);
}

void Canvas::AddNoise(cv::RNG* rng, double x_patch_m, double z_patch_m, double amplitude) {
  // Interpolates uniform random numbers on a coarse lattice.
  const cv::Size lattice(static_cast<int>(std::ceil(width_m_ / x_patch_m)) + 1,
                         static_cast<int>(std::ceil(height_m_ / z_patch_m)) + 1);
  cv::Mat coarse(lattice, CV_32FC1), fine;
  rng->fill(coarse, cv::RNG::UNIFORM, -amplitude, amplitude);
  cv::resize(coarse, fine, pixels_.size(), 0.0, 0.0, cv::INTER_LINEAR);
  cv::add(pixels_, fine, pixels_, cv::noArray(), CV_8UC1);
}

std::shared_ptr<const Texture> Canvas::ToTexture() const {
  return std::make_shared<const Texture>(pixels_);
}

}  // namespace cairn
