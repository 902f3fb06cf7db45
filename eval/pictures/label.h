// Text on pictures, and writing them.
#ifndef CAIRN_EVAL_PICTURES_LABEL_H_
#define CAIRN_EVAL_PICTURES_LABEL_H_

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

namespace cairn {

// Colours are BGR, as OpenCV's.
inline const cv::Scalar kInk(45, 38, 32);
inline const cv::Scalar kPaper(250, 251, 252);

enum class LabelAnchor { kLeft, kCenter, kRight };

// Writes `text` with its base line at `at`. `height_px` is that of capitals. A halo in the paper's
// colour keeps text legible on anything.
void DrawLabel(const std::string& text, cv::Point at, double height_px, const cv::Scalar& color,
               LabelAnchor anchor, bool halo, cv::Mat* image);

int LabelWidthPx(const std::string& text, double height_px);

// Colours of values in [0, 1]: dark blue over green to yellow and red, as CV_8UC3 BGR.
cv::Scalar ColorOf(double share);

// A vertical bar of ColorOf with ticks: `labels` from bottom to top, evenly spaced.
void DrawColorBar(const cv::Rect& bar, const std::vector<std::string>& labels, double height_px,
                  cv::Mat* image);

// Format by the extension. Throws Error(kIo) if the file cannot be written.
void WritePicture(const std::string& path, const cv::Mat& image);

}  // namespace cairn

#endif  // CAIRN_EVAL_PICTURES_LABEL_H_
