// Paints the surfaces of a street: walls, windows, shops, ornaments, pavement.
#ifndef CAIRN_CLI_DEMO_STREET_PAINT_H_
#define CAIRN_CLI_DEMO_STREET_PAINT_H_

#include <opencv2/core/mat.hpp>

#include "cli/demo/street/canvas.h"

namespace cairn {

inline constexpr double kFacadeTexelsPerM = 80.0;
inline constexpr double kGroundTexelsPerM = 56.0;

enum class WallKind { kPlaster, kBrick, kStone };

// Properties that are the same all over a house. The windows of a house are alike; only dirt,
// curtains and reflections tell them apart.
struct HouseStyle {
  WallKind wall = WallKind::kPlaster;
  double wall_gray = 150.0;
  double trim_gray = 200.0;  // Frames, sills, ornaments.
  double glass_gray = 60.0;
  int num_floors = 4;  // Above the ground floor.
  double ground_floor_m = 4.0;
  double floor_m = 3.3;
  double window_pitch_m = 2.2;  // Between window centers, before fitting to the width.
  double window_width_m = 1.1;
  double window_height_m = 1.7;
  int panes_x = 2, panes_z = 3;
  bool shutters = false;
  bool arched = false;  // A round lintel.
  int ornament = 0;     // Kind of the relief above windows, 0 to 3.
  bool shop = true;     // The ground floor is a shop.

  double height_m() const { return ground_floor_m + num_floors * floor_m + 0.9; }
};

HouseStyle RandomHouseStyle(cv::RNG* rng);

// The front of a house from the pavement to the roof.
Canvas PaintFacade(const HouseStyle& style, double width_m, cv::RNG* rng);
// The front of upper floors only, for bay windows. Has a whole number of windows.
Canvas PaintBay(const HouseStyle& style, double width_m, double height_m, cv::RNG* rng);
// A wall without windows, for sides of houses, columns and boxes.
Canvas PaintWall(const HouseStyle& style, double width_m, double height_m, cv::RNG* rng);
// Iron bars in front of a dark gap.
Canvas PaintRailing(double width_m, double height_m, cv::RNG* rng);
// Posters, for kiosks and advertising columns.
Canvas PaintPosters(double width_m, double height_m, cv::RNG* rng);
// A traffic or street-name sign.
Canvas PaintSign(double width_m, double height_m, cv::RNG* rng);
// Asphalt between two pavements of slabs. x runs along the street.
Canvas PaintGround(double length_m, double width_m, double sidewalk_m, cv::RNG* rng);

}  // namespace cairn

#endif  // CAIRN_CLI_DEMO_STREET_PAINT_H_
