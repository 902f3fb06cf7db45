#include "cli/demo/street/paint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <string>

#include "cli/demo/street/paint_parts.h"

namespace cairn {
namespace {

std::string RandomWord(cv::RNG* rng, int num_syllables) {
  static constexpr std::array<const char*, 20> kSyllables = {
      "BA",  "KO", "LI",  "MER", "TAN", "RO",  "SEL", "VI",  "GRA", "DUN",
      "FEN", "HO", "ZUR", "PAX", "NEL", "QUI", "WO",  "JAS", "CHE", "BRI"};
  std::string word;
  for (int i = 0; i < num_syllables; ++i) {
    word += kSyllables[rng->uniform(0, static_cast<int>(kSyllables.size()))];
  }
  return word;
}

std::string ShopName(cv::RNG* rng) {
  static constexpr std::array<const char*, 8> kTrades = {"CAFE", "BOOKS", "OPTIK",  "BAR",
                                                         "TOYS", "BANK",  "BAKERY", "HOTEL"};
  const std::string word = RandomWord(rng, rng->uniform(2, 4));
  return Chance(rng, 0.6) ? word + " " + kTrades[rng->uniform(0, static_cast<int>(kTrades.size()))]
                          : word;
}

// Paints rows of bricks or stones. Each is a little lighter or darker than the next.
void PaintMasonry(double stone_width_m, double stone_height_m, double joint_m, double spread,
                  double gray, cv::RNG* rng, Canvas* canvas) {
  bool shifted = false;
  for (double z = 0.0; z < canvas->height_m(); z += stone_height_m, shifted = !shifted) {
    for (double x = shifted ? -0.5 * stone_width_m : 0.0; x < canvas->width_m();
         x += stone_width_m) {
      canvas->FillRect(x, z, stone_width_m - joint_m, stone_height_m - joint_m,
                       gray + rng->gaussian(spread));
    }
  }
}

void PaintWallSurface(const HouseStyle& style, cv::RNG* rng, Canvas* canvas) {
  switch (style.wall) {
    case WallKind::kPlaster:
      for (int i = 0; i < static_cast<int>(canvas->width_m() * canvas->height_m() * 0.6); ++i) {
        // Flakes and cracks.
        const double x = rng->uniform(0.0, canvas->width_m());
        const double z = rng->uniform(0.0, canvas->height_m());
        canvas->FillEllipse(x, z, rng->uniform(0.02, 0.12), rng->uniform(0.02, 0.09),
                            style.wall_gray + rng->gaussian(14.0));
      }
      break;
    case WallKind::kBrick:
      PaintMasonry(0.26, 0.085, 0.015, 8.0, style.wall_gray - 8.0, rng, canvas);
      break;
    case WallKind::kStone:
      PaintMasonry(0.85, 0.42, 0.03, 9.0, style.wall_gray - 5.0, rng, canvas);
      break;
  }
}

// Adds dirt of all sizes. The largest patches make two equal houses differ, the smallest make two
// equal windows differ.
void Weather(double strength, cv::RNG* rng, Canvas* canvas) {
  canvas->AddPatches(rng, 2.5, 10.0 * strength);
  canvas->AddPatches(rng, 0.6, 10.0 * strength);
  canvas->AddStreaks(rng, 0.15, 1.2, 9.0 * strength);
  canvas->AddPatches(rng, 0.16, 10.0 * strength);
  canvas->AddPatches(rng, 0.05, 6.0 * strength);
}

void PaintDoor(const HouseStyle& style, const Box& box, cv::RNG* rng, Canvas* canvas) {
  canvas->FillRect(box.x - 0.15, 0.0, box.width + 0.3, box.height + 0.2, style.trim_gray);
  canvas->FillRect(box.x, 0.0, box.width, box.height, style.glass_gray + 20.0);
  for (int column = 0; column < 2; ++column) {
    for (int row = 0; row < 3; ++row) {
      canvas->FillRect(box.x + 0.08 + column * 0.5 * box.width, 0.15 + row * box.height / 3.2,
                       0.5 * box.width - 0.16, box.height / 3.2 - 0.12,
                       style.glass_gray + rng->uniform(35.0, 55.0));
    }
  }
  canvas->FillEllipse(box.x + 0.5 * box.width + 0.06, 1.05, 0.035, 0.05, 230.0);
  canvas->FillRect(box.x + box.width + 0.2, 1.4, 0.14, 0.24, 215.0);  // Bells.
  canvas->Text(box.x + box.width + 0.2, 2.0, 0.16, 0.3, std::to_string(rng->uniform(1, 99)), 240.0);
}

// Paints the contents of a shop window: goods and price tags.
void PaintGoods(const Box& box, cv::RNG* rng, Canvas* canvas) {
  canvas->FillRect(box.x, box.z, box.width, box.height, rng->uniform(35.0, 80.0));
  const int num_goods = static_cast<int>(box.width * box.height * 9.0);
  for (int i = 0; i < num_goods; ++i) {
    const double x = box.x + rng->uniform(0.02, 0.92) * box.width;
    const double z = box.z + rng->uniform(0.02, 0.85) * box.height;
    const double size = std::min(rng->uniform(0.06, 0.3), box.x + box.width - x);
    const double gray = rng->uniform(40.0, 240.0);
    if (Chance(rng, 0.4)) {
      canvas->FillEllipse(x, z, 0.5 * size, 0.4 * size, gray);
    } else {
      canvas->FillRect(x, z, size, size * rng->uniform(0.4, 1.2), gray);
      canvas->FillRect(x + 0.2 * size, z + 0.1 * size, 0.4 * size, 0.2 * size, 255.0 - gray);
    }
  }
  canvas->FillRect(box.x, box.z + box.height * 0.62, box.width, 0.04, 200.0);
}

void PaintShopFloor(const HouseStyle& style, cv::RNG* rng, Canvas* canvas) {
  const double height = style.ground_floor_m;
  canvas->FillRect(0.0, 0.0, canvas->width_m(), 0.45, style.wall_gray - 60.0);
  double x = 0.5;
  while (x + 2.0 < canvas->width_m()) {
    const double width = std::min(rng->uniform(2.8, 4.8), canvas->width_m() - 0.4 - x);
    const double sign_gray =
        Chance(rng, 0.5) ? rng->uniform(25.0, 70.0) : rng->uniform(190.0, 235.0);
    const double text_gray =
        sign_gray > 128.0 ? rng->uniform(10.0, 60.0) : rng->uniform(215.0, 250.0);
    canvas->FillRect(x - 0.1, 0.45, width + 0.1, height - 1.45, style.trim_gray);
    PaintGoods({x, 0.55, width - 1.25, height - 1.75}, rng, canvas);
    PaintDoor(style, {x + width - 1.05, 0.0, 0.85, 2.3}, rng, canvas);
    canvas->FillRect(x - 0.1, height - 0.95, width + 0.1, 0.7, sign_gray);
    canvas->Text(x + 0.15, height - 0.8, 0.38, width - 0.4, ShopName(rng), text_gray);
    x += width + 0.35;
  }
}

void PaintPlainFloor(const HouseStyle& style, cv::RNG* rng, Canvas* canvas) {
  canvas->FillRect(0.0, 0.0, canvas->width_m(), 0.7, style.wall_gray - 40.0);
  for (double z = 0.7; z < style.ground_floor_m - 0.3; z += 0.55) {
    canvas->FillRect(0.0, z, canvas->width_m(), 0.05, style.wall_gray - 45.0);
  }
  const int door_at = rng->uniform(0, std::max(1, static_cast<int>(canvas->width_m() / 2.4)));
  for (int i = 0; 0.6 + i * 2.4 + 1.4 < canvas->width_m(); ++i) {
    const double x = 0.6 + i * 2.4;
    if (i == door_at) {
      PaintDoor(style, {x, 0.0, 1.2, 2.5}, rng, canvas);
      canvas->Text(x - 0.1, 2.9, 0.2, 1.6, RandomWord(rng, 3), 240.0);
    } else {
      PaintWindow(style, {x, 1.2, 1.2, 1.6}, rng, canvas);
    }
  }
}

void PaintRoofCornice(const HouseStyle& style, Canvas* canvas) {
  const double z = canvas->height_m() - 0.8;
  canvas->FillRect(0.0, z, canvas->width_m(), 0.8, style.trim_gray - 10.0);
  for (double x = 0.1; x < canvas->width_m(); x += 0.4) {
    canvas->FillRect(x, z + 0.15, 0.22, 0.3, style.wall_gray - 60.0);
  }
}

// Paints scrawls that look like letters.
void PaintGraffiti(double x_m, double z_m, double size_m, cv::RNG* rng, Canvas* canvas) {
  const double gray = Chance(rng, 0.5) ? 25.0 : 235.0;
  for (int glyph = 0; glyph < rng->uniform(3, 7); ++glyph) {
    double x = x_m + glyph * 0.7 * size_m, z = z_m;
    for (int stroke = 0; stroke < 4; ++stroke) {
      const double next_x = x_m + (glyph * 0.7 + rng->uniform(0.0, 0.6)) * size_m;
      const double next_z = z_m + rng->uniform(0.0, 1.0) * size_m;
      canvas->Line(x, z, next_x, next_z, 0.035, gray);
      x = next_x;
      z = next_z;
    }
  }
}

}  // namespace

HouseStyle RandomHouseStyle(cv::RNG* rng) {
  HouseStyle style;
  style.wall = static_cast<WallKind>(rng->uniform(0, 3));
  style.wall_gray = rng->uniform(85.0, 190.0);
  style.trim_gray = std::clamp(
      style.wall_gray + (Chance(rng, 0.75) ? 1.0 : -1.0) * rng->uniform(25.0, 60.0), 50.0, 235.0);
  style.glass_gray = rng->uniform(35.0, 80.0);
  style.num_floors = rng->uniform(1, 5);
  style.ground_floor_m = rng->uniform(3.6, 4.4);
  style.floor_m = rng->uniform(3.0, 3.6);
  style.window_pitch_m = rng->uniform(1.9, 2.9);
  style.window_width_m = rng->uniform(0.9, 1.3);
  style.window_height_m = rng->uniform(1.5, 1.9);
  style.panes_x = rng->uniform(1, 4);
  style.panes_z = rng->uniform(1, 4);
  style.shutters = style.window_pitch_m > 2.4 && Chance(rng, 0.5);
  style.arched = Chance(rng, 0.3);
  style.ornament = rng->uniform(0, 4);
  style.shop = Chance(rng, 0.65);
  return style;
}

Canvas PaintFacade(const HouseStyle& style, double width_m, cv::RNG* rng) {
  Canvas canvas(width_m, style.height_m(), kFacadeTexelsPerM, style.wall_gray);
  PaintWallSurface(style, rng, &canvas);
  PaintFloors(style, style.ground_floor_m, 0.3, style.num_floors, rng, &canvas);
  if (style.shop) {
    PaintShopFloor(style, rng, &canvas);
  } else {
    PaintPlainFloor(style, rng, &canvas);
  }
  PaintRoofCornice(style, &canvas);
  if (Chance(rng, 0.6)) {
    PaintGraffiti(rng->uniform(0.2, 0.6) * width_m, rng->uniform(0.5, 1.2), rng->uniform(0.4, 0.9),
                  rng, &canvas);
  }
  Weather(1.0, rng, &canvas);
  return canvas;
}

Canvas PaintBay(const HouseStyle& style, double width_m, double height_m, cv::RNG* rng) {
  Canvas canvas(width_m, height_m, kFacadeTexelsPerM, style.wall_gray);
  PaintWallSurface(style, rng, &canvas);
  PaintFloors(style, 0.15, 0.1, static_cast<int>(height_m / style.floor_m), rng, &canvas);
  Weather(1.0, rng, &canvas);
  return canvas;
}

Canvas PaintWall(const HouseStyle& style, double width_m, double height_m, cv::RNG* rng) {
  Canvas canvas(width_m, height_m, kFacadeTexelsPerM, style.wall_gray);
  PaintWallSurface(style, rng, &canvas);
  Weather(1.2, rng, &canvas);
  return canvas;
}

Canvas PaintRailing(double width_m, double height_m, cv::RNG* rng) {
  Canvas canvas(width_m, height_m, kFacadeTexelsPerM, 60.0);
  for (double x = 0.04; x < width_m; x += 0.12) {
    canvas.FillRect(x, 0.0, 0.035, height_m, 165.0);
  }
  for (double x = 0.3; x < width_m; x += 0.6) {
    canvas.FillEllipse(x, 0.5 * height_m, 0.12, 0.12, 190.0);
    canvas.FillEllipse(x, 0.5 * height_m, 0.07, 0.07, 50.0);
  }
  canvas.FillRect(0.0, height_m - 0.08, width_m, 0.08, 185.0);
  canvas.FillRect(0.0, 0.0, width_m, 0.14, 150.0);
  Weather(1.0, rng, &canvas);
  return canvas;
}

Canvas PaintPosters(double width_m, double height_m, cv::RNG* rng) {
  Canvas canvas(width_m, height_m, kFacadeTexelsPerM, 110.0);
  for (double z = 0.3; z + 0.5 < height_m; z += 0.8) {
    for (double x = 0.05; x + 0.3 < width_m; x += 0.6) {
      const double gray = rng->uniform(40.0, 230.0), ink = gray > 128.0 ? 30.0 : 225.0;
      canvas.FillRect(x, z, 0.55, 0.75, gray);
      canvas.Text(x + 0.04, z + 0.55, 0.12, 0.46, RandomWord(rng, 2), ink);
      canvas.FillEllipse(x + rng->uniform(0.15, 0.4), z + 0.3, rng->uniform(0.06, 0.14),
                         rng->uniform(0.06, 0.18), rng->uniform(30.0, 240.0));
      canvas.Text(x + 0.04, z + 0.06, 0.06, 0.46, RandomWord(rng, 4), ink);
    }
  }
  Weather(0.8, rng, &canvas);
  return canvas;
}

Canvas PaintSign(double width_m, double height_m, cv::RNG* rng) {
  const double gray = Chance(rng, 0.5) ? 215.0 : 50.0, ink = 265.0 - gray;
  Canvas canvas(width_m, height_m, 2.0 * kFacadeTexelsPerM, ink);
  canvas.FillRect(0.04, 0.04, width_m - 0.08, height_m - 0.08, gray);
  canvas.Text(0.08, 0.58 * height_m, 0.22 * height_m, width_m - 0.16, RandomWord(rng, 2), ink);
  canvas.Text(0.08, 0.2 * height_m, 0.22 * height_m, width_m - 0.16, RandomWord(rng, 3), ink);
  Weather(0.5, rng, &canvas);
  return canvas;
}

Canvas PaintGround(double length_m, double width_m, double sidewalk_m, cv::RNG* rng) {
  Canvas canvas(length_m, width_m, kGroundTexelsPerM, 95.0);
  for (int i = 0; i < static_cast<int>(length_m * width_m * 0.5); ++i) {  // Repairs and spots.
    canvas.FillEllipse(rng->uniform(0.0, length_m), rng->uniform(0.0, width_m),
                       rng->uniform(0.02, 0.16), rng->uniform(0.02, 0.12),
                       95.0 + rng->gaussian(20.0));
  }
  for (double x = 1.0; x < length_m; x += 4.0) {  // Lane marks.
    canvas.FillRect(x, 0.5 * width_m - 0.07, 2.0, 0.14, 205.0);
  }
  for (double z = sidewalk_m + 0.5; z < width_m - sidewalk_m - 0.5; z += 1.0) {  // A crossing.
    canvas.FillRect(0.45 * length_m, z, 3.0, 0.5, 210.0);
  }
  for (const double curb : {0.0, width_m - sidewalk_m}) {
    canvas.FillRect(0.0, curb, length_m, sidewalk_m, 120.0);
    for (double x = 0.0; x < length_m; x += 0.5) {
      for (double z = curb; z < curb + sidewalk_m - 0.1; z += 0.5) {
        canvas.FillRect(x, z, 0.47, 0.47, 140.0 + rng->gaussian(9.0));
      }
    }
  }
  for (const double curb : {sidewalk_m - 0.15, width_m - sidewalk_m}) {
    canvas.FillRect(0.0, curb, length_m, 0.15, 175.0);
  }
  for (double x = 3.0; x < length_m; x += rng->uniform(6.0, 14.0)) {  // Manholes.
    const double z = rng->uniform(0.3, 0.7) * width_m;
    canvas.FillEllipse(x, z, 0.35, 0.35, 60.0);
    for (double bar = -0.24; bar <= 0.25; bar += 0.12) {
      canvas.FillRect(x - 0.22, z + bar, 0.44, 0.05, 125.0);
    }
  }
  Weather(0.9, rng, &canvas);
  return canvas;
}

}  // namespace cairn
