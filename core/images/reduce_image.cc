#include "core/images/reduce_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <opencv2/imgproc.hpp>

#include "core/error.h"

namespace cairn {
namespace {

// A view of the image's pixels.
cv::Mat AsMat(const GrayImage& image) {
  return cv::Mat(image.height_px, image.width_px, CV_8UC1,
                 const_cast<uint8_t*>(image.pixels.data()));
}

}  // namespace

GrayImage ReduceByArea(const GrayImage& image, int64_t max_pixels) {
  const double num_pixels = static_cast<double>(image.pixels.size());
  const double scale = std::sqrt(static_cast<double>(max_pixels) / num_pixels);
  GrayImage reduced;
  // A side shorter than a pixel becomes one pixel, which leaves fewer pixels for the other side.
  const auto reduce = [&](int side_px, int64_t at_most_px) {
    return static_cast<int>(std::clamp<int64_t>(static_cast<int64_t>(scale * side_px), 1,
                                                std::min<int64_t>(side_px, at_most_px)));
  };
  reduced.width_px = reduce(image.width_px, max_pixels);
  reduced.height_px = reduce(image.height_px, max_pixels / reduced.width_px);
  reduced.pixels.resize(static_cast<size_t>(reduced.width_px) * reduced.height_px);
  try {
    cv::Mat target = AsMat(reduced);
    cv::resize(AsMat(image), target, target.size(), 0.0, 0.0, cv::INTER_AREA);
  } catch (const cv::Exception& e) {
    if (e.code == cv::Error::StsNoMem) {
      throw std::bad_alloc();
    }
    throw Error(ErrorCode::kInternal, fmt::format("OpenCV cannot resize the image: {}", e.what()));
  }
  return reduced;
}

}  // namespace cairn
