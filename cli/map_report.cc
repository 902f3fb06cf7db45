#include "cli/map_report.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "core/angles.h"
#include "core/geodesy.h"
#include "core/printable.h"
#include "core/statistics.h"
#include "eval/pictures/round_down_125.h"

namespace cairn {
namespace {

constexpr double kWidthPx = 1100.0, kMarginPx = 40.0, kInnerPx = kWidthPx - 2.0 * kMarginPx;
constexpr double kMaxPlanHeightPx = 620.0, kMinPlanHeightPx = 160.0;
constexpr double kChartHeightPx = 90.0, kLinePx = 22.0;
constexpr double kTitleCapitalPx = 15.0, kCapitalPx = 9.5;
constexpr size_t kMaxLineBytes = 118;  // Of text that fits into the picture.
constexpr size_t kMaxReasons = 12;

constexpr DrawingColor kReportInk = 0x222222, kReportPale = 0x777777, kPositionColor = 0xa8a8a8,
                       kResidualColor = 0xdcdcdc, kLeftOutColor = 0xc62828;
// Told apart by people who do not see red and green alike (Okabe and Ito).
constexpr std::array<DrawingColor, 6> kSessionColors = {0x0072b2, 0xd55e00, 0x009e73,
                                                        0xcc79a7, 0xe69f00, 0x56b4e9};

using Places = std::vector<std::optional<Eigen::Vector2d>>;  // East and north, by photo.

// A session on the plan.
struct PlannedWay {
  DrawingColor color = 0;
  Places positions;  // By GPS.
  Places placed;     // Cameras where the positions alone place them.
  Places cameras;    // Cameras where they are now.
};

std::string FitLine(const std::string& text) { return Excerpt(text, kMaxLineBytes); }

// Where a camera stands in the map, ECEF.
Eigen::Vector3d InMap(const MapSessionResult& session, const Eigen::Vector3d& x_in_ecef) {
  const MapComparison& comparison = session.report.comparison;
  if (!session.is_in_map || session.report.is_unchanged || !IsJudged(comparison)) {
    return x_in_ecef;
  }
  const Eigen::Vector3d moved = comparison.fit.map_from_session * x_in_ecef;
  return comparison.bending.shift().is_zero() ? moved
                                              : moved + comparison.bending.shift().At(moved);
}

PlannedWay WayOf(const MapSessionResult& session, const Rigid3d& enu_from_ecef,
                 DrawingColor color) {
  PlannedWay way;
  way.color = color;
  const Sim3d& ecef_from_world = session.session.georegistration.ecef_from_world;
  const auto add = [&](const std::optional<Eigen::Vector3d>& x_in_ecef, Places* places) {
    places->push_back(x_in_ecef
                          ? std::optional<Eigen::Vector2d>((enu_from_ecef * *x_in_ecef).head<2>())
                          : std::nullopt);
  };
  for (size_t i = 0; i < session.mapped.center_of_photo.size(); ++i) {
    const auto in_ecef = [&](const std::optional<Eigen::Vector3d>& x_in_world) {
      return x_in_world ? std::optional<Eigen::Vector3d>(ecef_from_world * *x_in_world)
                        : std::nullopt;
    };
    const auto position = in_ecef(session.mapped.position_of_photo[i]);
    const auto placed = in_ecef(session.mapped.center_of_photo[i]);
    add(position, &way.positions);
    add(placed, &way.placed);
    add(placed ? std::optional(InMap(session, *placed)) : std::nullopt, &way.cameras);
  }
  return way;
}

std::vector<PlannedWay> WaysOf(const std::vector<MapSessionResult>& sessions) {
  std::optional<Rigid3d> enu_from_ecef;
  std::vector<PlannedWay> ways;
  for (size_t i = 0; i < sessions.size(); ++i) {
    if (!sessions[i].is_mapped) {
      ways.emplace_back();
      continue;
    }
    if (!enu_from_ecef) {
      enu_from_ecef =
          EcefFromEnu(
              GeodeticFromEcef(sessions[i].session.georegistration.ecef_from_world.translation))
              .Inverse();
    }
    ways.push_back(WayOf(sessions[i], *enu_from_ecef, kSessionColors[i % kSessionColors.size()]));
  }
  return ways;
}

// Maps east and north to pixels below `top_px`.
class PlanFrame {
 public:
  PlanFrame(const std::vector<PlannedWay>& ways, double top_px) : top_px_(top_px) {
    Eigen::Vector2d low = Eigen::Vector2d::Constant(1e300), high = -low;
    for (const PlannedWay& way : ways) {
      for (const Places* places : {&way.positions, &way.placed, &way.cameras}) {
        for (const auto& place : *places) {
          low = place ? low.cwiseMin(*place) : low;
          high = place ? high.cwiseMax(*place) : high;
        }
      }
    }
    if (low.x() > high.x()) {
      low = high = Eigen::Vector2d::Zero();
    }
    const Eigen::Vector2d extent = (high - low).cwiseMax(1e-3);
    middle_ = 0.5 * (low + high);
    px_per_m_ = std::min((kInnerPx - 2.0 * kInsetPx) / extent.x(),
                         (kMaxPlanHeightPx - 2.0 * kInsetPx) / extent.y());
    height_px_ = std::max(kMinPlanHeightPx, px_per_m_ * extent.y() + 2.0 * kInsetPx);
  }

  Eigen::Vector2d Pixel(const Eigen::Vector2d& at) const {
    const Eigen::Vector2d from_middle = px_per_m_ * (at - middle_);
    return {0.5 * kWidthPx + from_middle.x(), top_px_ + 0.5 * height_px_ - from_middle.y()};
  }
  double px_per_m() const { return px_per_m_; }
  double top_px() const { return top_px_; }
  double height_px() const { return height_px_; }
  double bottom_px() const { return top_px_ + height_px_; }

 private:
  static constexpr double kInsetPx = 30.0;

  double top_px_, height_px_ = 0.0, px_per_m_ = 1.0;
  Eigen::Vector2d middle_;
};

void AddWay(const Places& places, const PlanFrame& frame, DrawingColor color, double width_px,
            double radius_px, Drawing* drawing) {
  std::vector<Eigen::Vector2d> points;
  for (const auto& place : places) {
    if (place) {
      points.push_back(frame.Pixel(*place));
    }
  }
  for (const Eigen::Vector2d& point : points) {
    drawing->Disc(point, radius_px, color);
  }
  drawing->Polyline(std::move(points), color, width_px);
}

void AddPositions(const PlannedWay& way, const PlanFrame& frame, Drawing* drawing) {
  for (size_t i = 0; i < way.positions.size(); ++i) {
    if (way.positions[i] && way.placed[i]) {
      drawing->Line(frame.Pixel(*way.positions[i]), frame.Pixel(*way.placed[i]), kResidualColor,
                    1.5);
    }
  }
  AddWay(way.positions, frame, kPositionColor, 0.7, 2.5, drawing);
  for (size_t i = 0; i < way.positions.size(); ++i) {
    if (way.positions[i] && !way.placed[i]) {
      drawing->Ring(frame.Pixel(*way.positions[i]), 6.0, kLeftOutColor, 2.0);
    }
  }
}

void AddScaleAndNorth(const PlanFrame& frame, Drawing* drawing) {
  const double bar_m = RoundDown125(0.2 * kInnerPx / frame.px_per_m());
  const Eigen::Vector2d left(kMarginPx + 12.0, frame.bottom_px() - 14.0);
  const Eigen::Vector2d right = left + Eigen::Vector2d(bar_m * frame.px_per_m(), 0.0);
  drawing->Line(left, right, kReportInk, 2.0);
  for (const Eigen::Vector2d& end : {left, right}) {
    drawing->Line(end - Eigen::Vector2d(0, 4), end + Eigen::Vector2d(0, 4), kReportInk, 2.0);
  }
  drawing->Text(right + Eigen::Vector2d(8.0, 4.0), fmt::format("{} m", bar_m), kCapitalPx,
                kReportInk);
  const Eigen::Vector2d tip(kWidthPx - kMarginPx - 18.0, frame.top_px() + 26.0);
  drawing->Polyline({tip + Eigen::Vector2d(-5, 12), tip, tip + Eigen::Vector2d(5, 12)}, kReportInk,
                    2.0);
  drawing->Line(tip, tip + Eigen::Vector2d(0, 30), kReportInk, 2.0);
  drawing->Text(tip - Eigen::Vector2d(0, 6), "N", kCapitalPx, kReportInk, LabelAnchor::kCenter);
}

// A mark of the legend and its words; returns where the next one begins.
double AddLegendEntry(double x, double y, DrawingColor color, bool is_ring, const char* text,
                      Drawing* drawing) {
  const Eigen::Vector2d at(x + 5.0, y - 4.5);
  if (is_ring) {
    drawing->Ring(at, 5.0, color, 2.0);
  } else {
    drawing->Disc(at, 4.0, color);
  }
  drawing->Text({x + 16.0, y}, text, kCapitalPx, kReportInk);
  return x + 16.0 + LabelWidthPx(text, 2.0 * kCapitalPx) / 2.0 + 26.0;
}

void AddPlan(const std::vector<PlannedWay>& ways, const PlanFrame& frame, Drawing* drawing) {
  drawing->Box({kMarginPx, frame.top_px()}, {kInnerPx, frame.height_px()}, 0xfafafa);
  for (const PlannedWay& way : ways) {
    AddPositions(way, frame, drawing);
  }
  for (const PlannedWay& way : ways) {
    AddWay(way.cameras, frame, way.color, 1.6, 3.2, drawing);
  }
  AddScaleAndNorth(frame, drawing);
}

double MedianOf(std::vector<double> values) {
  return values.empty() ? 0.0 : Median(std::move(values));
}

std::string Meters(double value_m) {
  return value_m < 10.0 ? fmt::format("{:.2g} m", value_m) : fmt::format("{:.0f} m", value_m);
}

// A bar for each photo of the session: the level distance of its position from its camera.
void AddChart(const PlannedWay& way, double top_px, Drawing* drawing) {
  std::vector<double> residuals_m;
  for (size_t i = 0; i < way.positions.size(); ++i) {
    if (way.positions[i] && way.placed[i]) {
      residuals_m.push_back((*way.positions[i] - *way.placed[i]).norm());
    }
  }
  const double most_m =
      residuals_m.empty()
          ? 1.0
          : std::max(1e-3, *std::max_element(residuals_m.begin(), residuals_m.end()));
  const double median_m = MedianOf(residuals_m);
  const double bottom_px = top_px + kChartHeightPx, left_px = kMarginPx + 60.0;
  const double step_px =
      (kInnerPx - 60.0) / static_cast<double>(std::max<size_t>(1, way.positions.size()));
  const auto y_of = [&](double value_m) { return bottom_px - kChartHeightPx * value_m / most_m; };
  for (size_t i = 0; i < way.positions.size(); ++i) {
    const double x = left_px + static_cast<double>(i) * step_px;
    const double width_px = std::clamp(0.7 * step_px, 0.5, 24.0);
    if (way.positions[i] && way.placed[i]) {
      const double y = y_of((*way.positions[i] - *way.placed[i]).norm());
      drawing->Box({x, y}, {width_px, bottom_px - y}, way.color);
    } else if (!way.placed[i]) {
      drawing->Box({x, bottom_px - 7.0}, {width_px, 7.0}, kLeftOutColor);
    }
  }
  drawing->Line({left_px, bottom_px}, {kWidthPx - kMarginPx, bottom_px}, kReportPale, 1.0);
  drawing->Line({left_px, y_of(median_m)}, {kWidthPx - kMarginPx, y_of(median_m)}, kReportPale,
                0.7);
  const double label_x = left_px - 8.0;
  drawing->Text({label_x, top_px + 9.0}, Meters(most_m), kCapitalPx, kReportPale,
                LabelAnchor::kRight);
  // Not over the label of the largest.
  if (y_of(median_m) > top_px + 26.0) {
    drawing->Text({label_x, y_of(median_m) + 4.0}, Meters(median_m), kCapitalPx, kReportPale,
                  LabelAnchor::kRight);
  }
}

std::string Fate(const MapSessionResult& session) {
  if (!session.is_in_map) {
    return session.problem.empty() ? "not yet in the map" : "not in the map: " + session.problem;
  }
  const MapComparison& comparison = session.report.comparison;
  if (session.report.is_unchanged) {
    return "the map had it already";
  }
  if (!IsJudged(comparison)) {
    return "stands where its positions say";
  }
  return fmt::format(
      "{} of {} asked photos agree with the map: moved {:.2f} m, turned {:.2f} degrees, scaled by "
      "{:.4f}, bent up to {:.2f} m",
      comparison.fit.num_agreeing, comparison.num_asked(), comparison.fit.moved_m,
      comparison.fit.turned_rad * kDegPerRad, comparison.fit.scale, comparison.largest_bend_m);
}

std::string Figures(const MappedPhotos& mapped) {
  std::string text =
      fmt::format("{} of {} photos in the model", mapped.num_mapped, mapped.num_photos);
  for (const SegmentReport& segment : mapped.segments) {
    if (segment.problem.empty() && segment.is_placed_by_map) {
      text += fmt::format("; {} answers of the map, {:.2f} m median",
                          segment.georegistration.num_positions,
                          segment.georegistration.median_residual_m);
    } else if (segment.problem.empty()) {
      text += fmt::format("; {} observations, {:.2f} px, positions {:.2f} m median",
                          segment.adjustment.num_observations, segment.adjustment.rms_px,
                          segment.georegistration.median_residual_m);
    }
  }
  return text;
}

// Returns where the next session begins.
double AddSession(const MapSessionResult& session, const PlannedWay& way, double top_px,
                  Drawing* drawing) {
  drawing->Box({kMarginPx, top_px}, {12.0, 12.0}, session.is_mapped ? way.color : kLeftOutColor);
  drawing->Text({kMarginPx + 20.0, top_px + 11.0}, FitLine(session.name), kCapitalPx + 2.0,
                kReportInk);
  double y = top_px + 11.0 + kLinePx;
  if (session.is_mapped) {
    drawing->Text({kMarginPx + 20.0, y}, FitLine(Figures(session.mapped)), kCapitalPx, kReportInk);
    y += kLinePx;
  }
  drawing->Text({kMarginPx + 20.0, y}, FitLine(Fate(session)), kCapitalPx,
                session.problem.empty() ? kReportInk : kLeftOutColor);
  y += 14.0;
  if (session.is_mapped) {
    AddChart(way, y, drawing);
    y += kChartHeightPx;
  }
  return y + 26.0;
}

// A line for each reason: the first names, and how many there are.
std::vector<std::string> ReasonLines(const std::vector<MapSessionResult>& sessions) {
  std::map<std::string, std::vector<std::string>> names_of_reason;
  for (const MapSessionResult& session : sessions) {
    for (const LeftOutPhoto& photo : session.mapped.left_out) {
      names_of_reason[photo.reason].push_back(photo.name);
    }
  }
  std::vector<std::string> lines;
  for (const auto& [reason, names] : names_of_reason) {
    const std::string more = names.size() > 1 ? fmt::format(" and {} more", names.size() - 1) : "";
    lines.push_back(FitLine(fmt::format("{}{}: {}", Excerpt(names.front(), 40), more, reason)));
  }
  if (lines.size() > kMaxReasons) {
    lines.resize(kMaxReasons);
    lines.push_back("further reasons are in the summary");
  }
  return lines;
}

double HeightOf(const std::vector<MapSessionResult>& sessions, const PlanFrame& frame,
                size_t num_reasons) {
  double height = frame.bottom_px() + 2.5 * kLinePx;
  for (const MapSessionResult& session : sessions) {
    height += 51.0 + kLinePx + (session.is_mapped ? kChartHeightPx + kLinePx : 0.0);
  }
  return height + (num_reasons > 0 ? kLinePx * static_cast<double>(num_reasons + 2) : 0.0);
}

void AddReasons(const std::vector<std::string>& lines, double top_px, Drawing* drawing) {
  if (lines.empty()) {
    return;
  }
  double y = top_px + 8.0;
  drawing->Text({kMarginPx, y}, "Photos left out", kCapitalPx + 2.0, kReportInk);
  for (const std::string& line : lines) {
    y += kLinePx;
    drawing->Text({kMarginPx + 20.0, y}, line, kCapitalPx, kReportInk);
  }
}

}  // namespace

Drawing DrawMapReport(const std::vector<MapSessionResult>& sessions) {
  const std::vector<PlannedWay> ways = WaysOf(sessions);
  const PlanFrame frame(ways, 74.0);
  const std::vector<std::string> reasons = ReasonLines(sessions);
  Drawing drawing(kWidthPx, HeightOf(sessions, frame, reasons.size()));
  int num_photos = 0, num_mapped = 0, num_failed = 0;
  for (const MapSessionResult& session : sessions) {
    num_photos += session.mapped.num_photos;
    num_mapped += session.mapped.num_mapped;
    num_failed += session.is_mapped ? 0 : 1;
  }
  drawing.Text(
      {kMarginPx, 44.0},
      fmt::format("{} of {} photos, {} session{}{}", num_mapped, num_photos, sessions.size(),
                  sessions.size() == 1 ? "" : "s",
                  num_failed > 0 ? fmt::format(", {} of them without a model", num_failed) : ""),
      kTitleCapitalPx, kReportInk);
  AddPlan(ways, frame, &drawing);
  double y = frame.bottom_px() + kLinePx;
  double x = AddLegendEntry(kMarginPx, y, kPositionColor, false, "positions (before)", &drawing);
  x = AddLegendEntry(x, y, ways.front().color, false, "cameras (after)", &drawing);
  AddLegendEntry(x, y, kLeftOutColor, true, "left out", &drawing);
  y += kLinePx;
  for (size_t i = 0; i < sessions.size(); ++i) {
    y = AddSession(sessions[i], ways[i], y, &drawing);
  }
  AddReasons(reasons, y, &drawing);
  return drawing;
}

}  // namespace cairn
