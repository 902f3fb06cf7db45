// A picture of lines, dots and text that becomes SVG or PNG.
#ifndef CAIRN_EVAL_PICTURES_DRAWING_H_
#define CAIRN_EVAL_PICTURES_DRAWING_H_

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "eval/pictures/label.h"

namespace cairn {

// 0xRRGGBB.
using DrawingColor = uint32_t;

// Collects marks, later ones above earlier ones. x runs right and y down, in pixels; the paper is
// white. Both forms show the same.
class Drawing {
 public:
  Drawing(double width_px, double height_px) : width_px_(width_px), height_px_(height_px) {}

  double width_px() const { return width_px_; }
  double height_px() const { return height_px_; }

  void Line(const Eigen::Vector2d& from, const Eigen::Vector2d& to, DrawingColor color,
            double width_px);
  void Polyline(std::vector<Eigen::Vector2d> points, DrawingColor color, double width_px);
  void Disc(const Eigen::Vector2d& center, double radius_px, DrawingColor color);
  void Ring(const Eigen::Vector2d& center, double radius_px, DrawingColor color, double width_px);
  void Box(const Eigen::Vector2d& corner, const Eigen::Vector2d& size, DrawingColor color);
  // The baseline of the text is at `at`. `height_px` is the height of capitals. `text` is UTF-8;
  // characters beyond ASCII are '?' in the PNG.
  void Text(const Eigen::Vector2d& at, std::string text, double height_px, DrawingColor color,
            LabelAnchor anchor = LabelAnchor::kLeft);

  std::string ToSvg() const;
  // Twice as many pixels along each side, so that thin lines stay thin.
  std::vector<uint8_t> ToPng() const;

 private:
  enum class Kind { kLines, kDisc, kRing, kBox, kText };
  struct Mark {
    Kind kind = Kind::kLines;
    DrawingColor color = 0;
    // Of a disc or ring the center, of a box two corners, of a text its anchor.
    std::vector<Eigen::Vector2d> points = {};
    double size_px = 0.0;   // Radius, or height of capitals.
    double width_px = 0.0;  // Of lines.
    std::string text = {};
    LabelAnchor anchor = LabelAnchor::kLeft;
  };

  static std::string SvgOf(const Mark& mark);

  double width_px_, height_px_;
  std::vector<Mark> marks_;
};

}  // namespace cairn

#endif  // CAIRN_EVAL_PICTURES_DRAWING_H_
