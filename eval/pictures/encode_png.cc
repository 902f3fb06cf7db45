#include "eval/pictures/encode_png.h"

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/error.h"

namespace cairn {

std::vector<uint8_t> EncodePng(const GrayImage& image) {
  try {
    const cv::Mat pixels(image.height_px, image.width_px, CV_8UC1,
                         const_cast<uint8_t*>(image.pixels.data()));
    std::vector<uint8_t> bytes;
    cv::imencode(".png", pixels, bytes);
    return bytes;
  } catch (const cv::Exception& error) {
    throw Error(ErrorCode::kInternal, std::string("cannot encode a PNG: ") + error.what());
  }
}

}  // namespace cairn
