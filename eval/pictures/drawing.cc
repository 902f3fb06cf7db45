#include "eval/pictures/drawing.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "eval/pictures/html_text.h"

namespace cairn {
namespace {

constexpr double kPngScale = 2.0;
// OpenCV takes coordinates in this share of a pixel.
constexpr int kShareBits = 4;
// Height of a font over that of its capitals.
constexpr double kFontPerCapital = 1.4;

std::string Hex(DrawingColor color) { return fmt::format("#{:06x}", color); }

std::string Ascii(const std::string& text) {
  std::string ascii;
  for (const char letter : text) {
    const auto byte = static_cast<unsigned char>(letter);
    if (byte >= 0xc0) {
      ascii += '?';  // The first byte of a character; the others follow.
    } else if (byte >= 0x20 && byte < 0x7f) {
      ascii += letter;
    }
  }
  return ascii;
}

cv::Scalar Bgr(DrawingColor color) {
  return {static_cast<double>(color & 0xff), static_cast<double>(color >> 8 & 0xff),
          static_cast<double>(color >> 16 & 0xff)};
}

// In shares of a pixel.
int Fixed(double px) { return static_cast<int>(std::lround(px * kPngScale * (1 << kShareBits))); }
cv::Point Fixed(const Eigen::Vector2d& at) { return {Fixed(at.x()), Fixed(at.y())}; }
cv::Point Whole(const Eigen::Vector2d& at) {
  return {static_cast<int>(std::lround(at.x() * kPngScale)),
          static_cast<int>(std::lround(at.y() * kPngScale))};
}
int StrokePx(double width_px) {
  return std::max(1, static_cast<int>(std::lround(width_px * kPngScale)));
}

}  // namespace

void Drawing::Line(const Eigen::Vector2d& from, const Eigen::Vector2d& to, DrawingColor color,
                   double width_px) {
  Polyline({from, to}, color, width_px);
}

void Drawing::Polyline(std::vector<Eigen::Vector2d> points, DrawingColor color, double width_px) {
  marks_.push_back(
      {.kind = Kind::kLines, .color = color, .points = std::move(points), .width_px = width_px});
}

void Drawing::Disc(const Eigen::Vector2d& center, double radius_px, DrawingColor color) {
  marks_.push_back({.kind = Kind::kDisc, .color = color, .points = {center}, .size_px = radius_px});
}

void Drawing::Ring(const Eigen::Vector2d& center, double radius_px, DrawingColor color,
                   double width_px) {
  marks_.push_back({.kind = Kind::kRing,
                    .color = color,
                    .points = {center},
                    .size_px = radius_px,
                    .width_px = width_px});
}

void Drawing::Box(const Eigen::Vector2d& corner, const Eigen::Vector2d& size, DrawingColor color) {
  marks_.push_back({.kind = Kind::kBox, .color = color, .points = {corner, corner + size}});
}

void Drawing::Text(const Eigen::Vector2d& at, std::string text, double height_px,
                   DrawingColor color, LabelAnchor anchor) {
  marks_.push_back({.kind = Kind::kText,
                    .color = color,
                    .points = {at},
                    .size_px = height_px,
                    .text = std::move(text),
                    .anchor = anchor});
}

std::string Drawing::SvgOf(const Mark& mark) {
  const std::string color = Hex(mark.color);
  const Eigen::Vector2d at = mark.points.empty() ? Eigen::Vector2d::Zero() : mark.points.front();
  switch (mark.kind) {
    case Kind::kLines: {
      std::string points;
      for (const Eigen::Vector2d& point : mark.points) {
        points += fmt::format("{:.1f},{:.1f} ", point.x(), point.y());
      }
      return fmt::format(
          "<polyline points='{}' fill='none' stroke='{}' stroke-width='{}' "
          "stroke-linejoin='round'/>\n",
          points, color, mark.width_px);
    }
    case Kind::kDisc:
      return fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='{}' fill='{}'/>\n", at.x(), at.y(),
                         mark.size_px, color);
    case Kind::kRing:
      return fmt::format(
          "<circle cx='{:.1f}' cy='{:.1f}' r='{}' fill='none' stroke='{}' stroke-width='{}'/>\n",
          at.x(), at.y(), mark.size_px, color, mark.width_px);
    case Kind::kBox: {
      const Eigen::Vector2d size = mark.points.back() - at;
      return fmt::format("<rect x='{:.1f}' y='{:.1f}' width='{:.1f}' height='{:.1f}' fill='{}'/>\n",
                         at.x(), at.y(), size.x(), size.y(), color);
    }
    case Kind::kText:
      break;
  }
  const char* anchor = mark.anchor == LabelAnchor::kRight    ? "end"
                       : mark.anchor == LabelAnchor::kCenter ? "middle"
                                                             : "start";
  return fmt::format(
      "<text x='{:.1f}' y='{:.1f}' font-size='{:.1f}' fill='{}' text-anchor='{}'>{}</text>\n",
      at.x(), at.y(), kFontPerCapital * mark.size_px, color, anchor, HtmlText(mark.text));
}

std::string Drawing::ToSvg() const {
  std::string svg = fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' width='{0:.0f}' height='{1:.0f}' viewBox='0 0 "
      "{0:.0f} {1:.0f}' font-family='sans-serif'>\n<rect width='100%' height='100%' "
      "fill='white'/>\n",
      width_px_, height_px_);
  for (const Mark& mark : marks_) {
    svg += SvgOf(mark);
  }
  return svg + "</svg>\n";
}

std::vector<uint8_t> Drawing::ToPng() const {
  const cv::Point size = Whole({width_px_, height_px_});
  cv::Mat image(size.y, size.x, CV_8UC3, cv::Scalar::all(255.0));
  for (const Mark& mark : marks_) {
    const cv::Scalar color = Bgr(mark.color);
    switch (mark.kind) {
      case Kind::kLines:
        for (size_t i = 1; i < mark.points.size(); ++i) {
          cv::line(image, Fixed(mark.points[i - 1]), Fixed(mark.points[i]), color,
                   StrokePx(mark.width_px), cv::LINE_AA, kShareBits);
        }
        break;
      case Kind::kDisc:
        cv::circle(image, Fixed(mark.points[0]), Fixed(mark.size_px), color, cv::FILLED,
                   cv::LINE_AA, kShareBits);
        break;
      case Kind::kRing:
        cv::circle(image, Fixed(mark.points[0]), Fixed(mark.size_px), color,
                   StrokePx(mark.width_px), cv::LINE_AA, kShareBits);
        break;
      case Kind::kBox:
        cv::rectangle(image, Fixed(mark.points[0]), Fixed(mark.points[1]), color, cv::FILLED,
                      cv::LINE_AA, kShareBits);
        break;
      case Kind::kText:
        DrawLabel(Ascii(mark.text), Whole(mark.points[0]), kPngScale * mark.size_px, color,
                  mark.anchor, /*halo=*/false, &image);
        break;
    }
  }
  return EncodePicture(".png", image);
}

}  // namespace cairn
