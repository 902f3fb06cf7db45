#include "cli/exports/point_colors.h"

#include <algorithm>
#include <cmath>

namespace cairn {
namespace {

// From blue over green and yellow to red; `share` is from 0 to 1.
Rgb ColorOfShare(double share) {
  constexpr std::array<Rgb, 5> kStops = {
      {{48, 18, 180}, {30, 140, 230}, {60, 190, 90}, {240, 200, 40}, {215, 40, 30}}};
  const double place = std::clamp(share, 0.0, 1.0) * (kStops.size() - 1);
  const size_t below = std::min(static_cast<size_t>(place), kStops.size() - 2);
  const double part = place - static_cast<double>(below);
  Rgb color;
  for (size_t i = 0; i < color.size(); ++i) {
    color[i] = static_cast<uint8_t>(
        std::lround((1.0 - part) * kStops[below][i] + part * kStops[below + 1][i]));
  }
  return color;
}

}  // namespace

Rgb ColorOfSession(SessionId session_id) {
  // Tableau's ten, which people with any color vision tell apart best.
  constexpr std::array<Rgb, 10> kColors = {{{31, 119, 180},
                                            {255, 127, 14},
                                            {44, 160, 44},
                                            {214, 39, 40},
                                            {148, 103, 189},
                                            {140, 86, 75},
                                            {227, 119, 194},
                                            {188, 189, 34},
                                            {23, 190, 207},
                                            {90, 90, 90}}};
  constexpr Rgb kGray = {160, 160, 160};
  const int64_t id = Value(session_id);
  return id <= 0 ? kGray : kColors[static_cast<size_t>((id - 1) % std::ssize(kColors))];
}

Rgb ColorOfHeight(double height_over_cameras_m) {
  constexpr double kLowestM = -5.0, kHighestM = 25.0;
  return ColorOfShare((height_over_cameras_m - kLowestM) / (kHighestM - kLowestM));
}

Rgb ColorOfUncertainty(double sigma_m) {
  constexpr double kLeastM = 0.01, kMostM = 1.0;
  return ColorOfShare(std::log(std::max(sigma_m, kLeastM) / kLeastM) / std::log(kMostM / kLeastM));
}

}  // namespace cairn
