// Draws text and color scales on pictures, and writes pictures to files.
#ifndef CAIRN_EVAL_PICTURES_LABEL_H_
#define CAIRN_EVAL_PICTURES_LABEL_H_

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

namespace cairn {

// Colors are BGR, as in OpenCV.
inline const cv::Scalar kInk(45, 38, 32);
inline const cv::Scalar kPaper(250, 251, 252);

enum class LabelAnchor { kLeft, kCenter, kRight };

// Draws `text` with its baseline at `at`. `height_px` is the height of capitals. The halo has the
// paper's color and keeps text legible on any background.
void DrawLabel(const std::string& text, cv::Point at, double height_px, const cv::Scalar& color,
               LabelAnchor anchor, bool halo, cv::Mat* image);

int LabelWidthPx(const std::string& text, double height_px);

// Colors of values in [0, 1], from dark blue over green to yellow and red, as CV_8UC3 BGR.
cv::Scalar ColorOf(double share);

// A vertical bar of ColorOf with ticks. `labels` go from bottom to top, evenly spaced.
void DrawColorBar(const cv::Rect& bar, const std::vector<std::string>& labels, double height_px,
                  cv::Mat* image);

// Encodes a CV_8UC3 picture in the format of an extension that PictureExtension returns.
std::vector<uint8_t> EncodePicture(const std::string& extension, const cv::Mat& image);

// The extension selects the format. Throws Error(kIo) if the file cannot be written, and as
// PictureExtension.
void WritePicture(const std::string& path, const cv::Mat& image);

}  // namespace cairn

#endif  // CAIRN_EVAL_PICTURES_LABEL_H_
