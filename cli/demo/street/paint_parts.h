// Functions that paint.cc and paint_windows.cc share. Private to the two.
#ifndef CAIRN_CLI_DEMO_STREET_PAINT_PARTS_H_
#define CAIRN_CLI_DEMO_STREET_PAINT_PARTS_H_

#include <opencv2/core.hpp>

#include "cli/demo/street/canvas.h"
#include "cli/demo/street/paint.h"

namespace cairn {

// Lower left corner and size on a canvas, in meters.
struct Box {
  double x, z, width, height;
};

inline bool Chance(cv::RNG* rng, double probability) {
  return rng->uniform(0.0, 1.0) < probability;
}

void PaintWindow(const HouseStyle& style, const Box& box, cv::RNG* rng, Canvas* canvas);
// Rows of windows, one per floor.
void PaintFloors(const HouseStyle& style, double first_floor_z_m, double margin_m, int num_floors,
                 cv::RNG* rng, Canvas* canvas);

}  // namespace cairn

#endif  // CAIRN_CLI_DEMO_STREET_PAINT_PARTS_H_
