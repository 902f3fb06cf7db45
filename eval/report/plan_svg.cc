#include "eval/report/plan_svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "eval/pictures/html_text.h"
#include "eval/pictures/pictures.h"
#include "eval/pictures/plan_content.h"
#include "eval/pictures/round_down_125.h"

namespace cairn {
namespace {

constexpr double kWidthPx = 960.0;
constexpr double kMaxHeightPx = 900.0;
// Enough for the outlines of houses; more make the page slow and show no more.
constexpr size_t kMaxLandmarks = 6000;
// Queries on the plan; the rest are in the table and the CSV.
constexpr size_t kMaxQueries = 2000;

constexpr RecallThreshold kFineBound = {0.25, 2.0 * kRadPerDeg};
constexpr RecallThreshold kGoodBound = {0.5, 5.0 * kRadPerDeg};

// Meters east and north to pixels right and down.
struct Frame {
  PlanArea area;
  double px_per_m = 1.0;

  double X(const Eigen::Vector2d& at) const { return px_per_m * (at.x() - area.low.x()); }
  double Y(const Eigen::Vector2d& at) const { return px_per_m * (area.high.y() - at.y()); }
};

Frame FrameOf(const PlanArea& area) {
  const Eigen::Vector2d size = (area.high - area.low).cwiseMax(1.0);
  return {area, std::min(kWidthPx / size.x(), kMaxHeightPx / size.y())};
}

std::string Tiles(const PlanContent& content, const Frame& frame) {
  std::string svg;
  for (const PlanTile& tile : content.tiles) {
    svg += "<polygon class=\"tile\" points=\"";
    for (const Eigen::Vector2d& corner : tile.corners) {
      svg += fmt::format("{:.1f},{:.1f} ", frame.X(corner), frame.Y(corner));
    }
    svg += fmt::format("\"><title>tile {}</title></polygon>\n", HtmlText(tile.name));
  }
  return svg;
}

// One path of dots.
std::string Landmarks(const PlanContent& content, const Frame& frame) {
  const size_t stride = content.landmarks.size() / kMaxLandmarks + 1;
  std::string svg = "<path class=\"landmarks\" d=\"";
  for (size_t i = 0; i < content.landmarks.size(); i += stride) {
    const Eigen::Vector2d at = content.landmarks[i].head<2>();
    svg += fmt::format("M{:.0f} {:.0f}h1", frame.X(at), frame.Y(at));
  }
  return svg + "\"/>\n";
}

std::string Direction(const PlanPose& pose, double length_px, const Frame& frame) {
  return fmt::format("M{:.1f} {:.1f}l{:.1f} {:.1f}", frame.X(pose.center), frame.Y(pose.center),
                     length_px * pose.forward.x(), -length_px * pose.forward.y());
}

std::string Keyframes(const PlanContent& content, const Frame& frame) {
  std::string dots = "<path class=\"keyframes\" d=\"", rays = "<path class=\"rays\" d=\"";
  for (const PlanPose& keyframe : content.keyframes) {
    dots += fmt::format("M{:.1f} {:.1f}h0", frame.X(keyframe.center), frame.Y(keyframe.center));
    rays += Direction(keyframe, 7.0, frame);
  }
  return rays + "\"/>\n" + dots + "\"/>\n";
}

std::string QueryMark(size_t idx, const EvalQuery& query, const EvalAnswer& answer,
                      const PlanContent& content, const Frame& frame) {
  const Rigid3d ecef_from_plan = content.plan_from_ecef.Inverse();
  const PlanPose truth = OnPlan(query.cam_from_ecef * ecef_from_plan);
  const char* grade = GradeClass(GradeOf(answer));
  std::string svg = fmt::format("<a class=\"{}\" href=\"#q{}\"><title>{}: {}</title>", grade, idx,
                                HtmlText(query.name), GradeText(GradeOf(answer)));
  const double x = frame.X(truth.center), y = frame.Y(truth.center);
  svg += fmt::format("<path class=\"ray\" d=\"{}\"/>", Direction(truth, 14.0, frame));
  svg += fmt::format("<circle class=\"truth\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"6\"/>", x, y);
  if (answer.result.localized) {
    const PlanPose pose = OnPlan(answer.result.cam_from_ecef * ecef_from_plan);
    svg += fmt::format(
        "<path class=\"ray\" d=\"M{0:.1f} {1:.1f}L{2:.1f} {3:.1f}\"/>"
        "<circle class=\"answer\" cx=\"{2:.1f}\" cy=\"{3:.1f}\" r=\"3.2\"/>",
        x, y, frame.X(pose.center), frame.Y(pose.center));
  } else {
    svg +=
        fmt::format("<path class=\"ray\" d=\"M{:.1f} {:.1f}l8 8m0 -8l-8 8\"/>", x - 4.0, y - 4.0);
  }
  return svg + "</a>\n";
}

// A bar of 1, 2 or 5 times a power of ten, about an eighth of the width.
std::string ScaleBar(const Frame& frame, double height_px) {
  const double length_m = RoundDown125(0.125 * kWidthPx / frame.px_per_m);
  return fmt::format(
      "<path class=\"scale\" d=\"M12 {0:.1f}v6h{1:.1f}v-6\"/>"
      "<text x=\"16\" y=\"{0:.1f}\">{2:g} m, north is up</text>\n",
      height_px - 16.0, frame.px_per_m * length_m, length_m);
}

}  // namespace

AnswerGrade GradeOf(const EvalAnswer& answer) {
  if (!answer.result.localized) {
    return AnswerGrade::kNone;
  }
  if (IsWithin(answer, kFineBound)) {
    return AnswerGrade::kFine;
  }
  if (IsWithin(answer, kGoodBound)) {
    return AnswerGrade::kGood;
  }
  return IsWithin(answer, kCorrect) ? AnswerGrade::kFair : AnswerGrade::kWrong;
}

const char* GradeClass(AnswerGrade grade) {
  constexpr const char* kNames[] = {"fine", "good", "fair", "wrong", "none"};
  return kNames[static_cast<int>(grade)];
}

const char* GradeText(AnswerGrade grade) {
  constexpr const char* kTexts[] = {"within 0.25 m and 2°", "within 0.5 m and 5°",
                                    "within 3 m and 10°", "wrong", "not localized"};
  return kTexts[static_cast<int>(grade)];
}

std::string PlanAsSvg(const MapSnapshot& map, const std::vector<EvalQuery>& queries,
                      const EvalReport& report) {
  std::vector<TopViewPose> poses;
  for (size_t i = 0; i < queries.size(); ++i) {
    TopViewPose pose;
    pose.reference_cam_from_ecef = queries[i].cam_from_ecef;
    // A wrong answer may be anywhere; the plan shows the street, not the way there.
    if (IsWithin(report.answers[i], kCorrect)) {
      pose.estimated_cam_from_ecef = report.answers[i].result.cam_from_ecef;
    }
    poses.push_back(std::move(pose));
  }
  const PlanContent content = LoadPlanContent(map, poses);
  const Frame frame = FrameOf(content.area);
  const double height_px = frame.px_per_m * (content.area.high - content.area.low).y();
  std::string svg = fmt::format(
      "<svg class=\"plan\" viewBox=\"0 0 {:.0f} {:.0f}\" role=\"img\" aria-label=\"The map and the "
      "queries in plan\">\n",
      kWidthPx, height_px);
  svg += Tiles(content, frame) + Landmarks(content, frame) + Keyframes(content, frame);
  for (size_t i = 0; i < std::min(queries.size(), kMaxQueries); ++i) {
    svg += QueryMark(i, queries[i], report.answers[i], content, frame);
  }
  return svg + ScaleBar(frame, height_px) + "</svg>\n";
}

}  // namespace cairn
