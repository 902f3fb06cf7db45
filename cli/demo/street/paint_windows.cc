// The windows of facades.
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "cli/demo/street/paint_parts.h"
#include "core/angles.h"

namespace cairn {
namespace {

void PaintOrnament(const HouseStyle& style, const Box& box, Canvas* canvas) {
  const double middle = box.x + 0.5 * box.width;
  switch (style.ornament) {
    case 1:  // A gable.
      canvas->Line(box.x - 0.1, box.z, middle, box.z + box.height, 0.08, style.trim_gray);
      canvas->Line(middle, box.z + box.height, box.x + box.width + 0.1, box.z, 0.08,
                   style.trim_gray);
      canvas->FillEllipse(middle, box.z + 0.3 * box.height, 0.09, 0.09, style.trim_gray - 60.0);
      break;
    case 2:  // Dentils.
      for (double x = box.x - 0.08; x < box.x + box.width; x += 0.16) {
        canvas->FillRect(x, box.z + 0.05, 0.09, 0.14, style.trim_gray);
      }
      canvas->FillRect(box.x - 0.1, box.z + 0.19, box.width + 0.2, 0.08, style.trim_gray);
      break;
    case 3:  // A keystone with a ring.
      canvas->FillRect(middle - 0.1, box.z, 0.2, 0.35, style.trim_gray);
      canvas->FillEllipse(middle, box.z + 0.18, 0.06, 0.06, style.wall_gray - 50.0);
      canvas->FillRect(box.x - 0.1, box.z, box.width + 0.2, 0.06, style.trim_gray);
      break;
    default:
      canvas->FillRect(box.x - 0.12, box.z, box.width + 0.24, 0.12, style.trim_gray);
      break;
  }
}

void PaintGlass(const HouseStyle& style, const Box& box, cv::RNG* rng, Canvas* canvas) {
  canvas->FillRect(box.x, box.z, box.width, box.height, style.glass_gray);
  // The upper panes reflect the sky. A curtain is partly drawn.
  const double reflection = rng->uniform(0.2, 0.6);
  canvas->FillRect(box.x, box.z + box.height * (1.0 - reflection), box.width,
                   box.height * reflection, style.glass_gray + rng->uniform(15.0, 50.0));
  if (Chance(rng, 0.55)) {
    const double drawn = rng->uniform(0.15, 0.45) * box.width;
    const double gray = rng->uniform(120.0, 210.0);
    canvas->FillRect(box.x, box.z, drawn, box.height, gray);
    canvas->FillRect(box.x + box.width - drawn, box.z, drawn, box.height, gray - 6.0);
    for (double x = 0.04; x < drawn; x += 0.07) {
      canvas->FillRect(box.x + x, box.z, 0.02, box.height, gray - 30.0);
    }
  }
  if (Chance(rng, 0.35)) {  // A blind.
    const double height = rng->uniform(0.15, 0.7) * box.height;
    for (double z = 0.0; z < height; z += 0.06) {
      canvas->FillRect(box.x, box.z + box.height - z - 0.06, box.width, 0.045, 175.0);
    }
  }
  if (Chance(rng, 0.4)) {  // A plant on the sill.
    const double x = box.x + rng->uniform(0.2, 0.8) * box.width;
    for (int leaf = 0; leaf < 9; ++leaf) {
      canvas->FillEllipse(x + rng->gaussian(0.10), box.z + 0.18 + rng->gaussian(0.07), 0.05, 0.03,
                          rng->uniform(20.0, 130.0));
    }
  }
}

}  // namespace

void PaintWindow(const HouseStyle& style, const Box& box, cv::RNG* rng, Canvas* canvas) {
  constexpr double kFrameM = 0.07;
  canvas->FillRect(box.x - 2 * kFrameM, box.z - kFrameM, box.width + 4 * kFrameM,
                   box.height + 3 * kFrameM, style.trim_gray - 25.0);
  canvas->FillRect(box.x - kFrameM, box.z, box.width + 2 * kFrameM, box.height + kFrameM,
                   style.trim_gray);
  PaintGlass(style, box, rng, canvas);
  for (int i = 1; i < style.panes_x; ++i) {
    canvas->FillRect(box.x + box.width * i / style.panes_x - 0.03, box.z, 0.06, box.height,
                     style.trim_gray);
  }
  for (int i = 1; i < style.panes_z; ++i) {
    canvas->FillRect(box.x, box.z + box.height * i / style.panes_z - 0.02, box.width, 0.04,
                     style.trim_gray);
  }
  // The sill and its shadow.
  canvas->FillRect(box.x - 0.18, box.z - 0.14, box.width + 0.36, 0.1, style.trim_gray + 10.0);
  canvas->FillRect(box.x - 0.14, box.z - 0.2, box.width + 0.28, 0.06, style.wall_gray - 70.0);
  if (style.arched) {
    for (int step = 0; step <= 12; ++step) {
      const double angle = kPi * step / 12.0;
      canvas->FillRect(box.x + 0.5 * box.width * (1.0 - std::cos(angle)) - 0.05,
                       box.z + box.height + 0.08 + 0.3 * std::sin(angle), 0.1, 0.1,
                       step % 2 ? style.trim_gray : style.trim_gray - 35.0);
    }
  } else {
    PaintOrnament(style, {box.x, box.z + box.height + 0.14, box.width, 0.4}, canvas);
  }
  if (style.shutters) {
    const double width = 0.42 * box.width;
    for (const double x : {box.x - width - 0.12, box.x + box.width + 0.12}) {
      canvas->FillRect(x, box.z, width, box.height, style.glass_gray + 30.0);
      for (double z = 0.06; z < box.height - 0.05; z += 0.1) {
        canvas->FillRect(x + 0.04, box.z + z, width - 0.08, 0.045, style.glass_gray + 65.0);
      }
    }
  }
}

void PaintFloors(const HouseStyle& style, double first_floor_z_m, double margin_m, int num_floors,
                 cv::RNG* rng, Canvas* canvas) {
  const double usable = canvas->width_m() - 2.0 * margin_m;
  const int num_windows = std::max(1, static_cast<int>(usable / style.window_pitch_m));
  const double pitch = usable / num_windows;
  for (int floor = 0; floor < num_floors; ++floor) {
    const double z = first_floor_z_m + floor * style.floor_m;
    canvas->FillRect(0.0, z - 0.12, canvas->width_m(), 0.14, style.trim_gray - 15.0);
    canvas->FillRect(0.0, z - 0.17, canvas->width_m(), 0.05, style.wall_gray - 55.0);
    for (int i = 0; i < num_windows; ++i) {
      const double x = margin_m + (i + 0.5) * pitch - 0.5 * style.window_width_m;
      PaintWindow(style, {x, z + 0.75, style.window_width_m, style.window_height_m}, rng, canvas);
    }
  }
}

}  // namespace cairn
