#include "cli/demo/street/build_street.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <opencv2/core.hpp>
#include <utility>

#include "cli/demo/street/paint.h"
#include "cli/demo/street/trees.h"

namespace cairn {
namespace {

using TexturePtr = std::shared_ptr<const Texture>;

constexpr double kHouseDepthM = 8.0;

// A vertical plane, as seen by a viewer in front of it: a runs right, o toward the viewer, z up
// from the pavement.
struct FrontFrame {
  Eigen::Vector3d origin_in_street;
  Eigen::Vector3d out_in_street;  // Unit, horizontal.

  Eigen::Vector3d Right() const { return (-out_in_street).cross(Eigen::Vector3d::UnitZ()); }
  Eigen::Vector3d Point(double a, double o, double z) const {
    return origin_in_street + a * Right() + o * out_in_street + z * Eigen::Vector3d::UnitZ();
  }
};

// Extent of a box in a FrontFrame, meters.
struct BoxExtent {
  double a0, a1, o0, o1, z0, z1;
};

struct BoxTextures {
  TexturePtr front, sides, caps;  // Null faces are left out.
};

// Collects rectangles in the street frame.
class StreetBuilder {
 public:
  void AddRect(const Eigen::Vector3d& corner, const Eigen::Vector3d& u, const Eigen::Vector3d& v,
               const TexturePtr& texture) {
    if (texture) {
      rects_.push_back({corner, u, v, texture});
    }
  }

  void AddBox(const FrontFrame& frame, const BoxExtent& box, const BoxTextures& textures) {
    const Eigen::Vector3d right = frame.Right() * (box.a1 - box.a0);
    const Eigen::Vector3d out = frame.out_in_street * (box.o1 - box.o0);
    const Eigen::Vector3d down = -Eigen::Vector3d::UnitZ() * (box.z1 - box.z0);
    AddRect(frame.Point(box.a0, box.o1, box.z1), right, down, textures.front);
    AddRect(frame.Point(box.a0, box.o0, box.z1), out, down, textures.sides);
    AddRect(frame.Point(box.a1, box.o1, box.z1), -out, down, textures.sides);
    AddRect(frame.Point(box.a0, box.o0, box.z1), right, out, textures.caps);
    AddRect(frame.Point(box.a0, box.o1, box.z0), right, -out, textures.caps);
  }

  std::vector<TexturedRect>* rects() { return &rects_; }

  std::vector<TexturedRect> Finish(const Rigid3d& enu_from_street) && {
    for (TexturedRect& rect : rects_) {
      rect.corner_in_enu = enu_from_street * rect.corner_in_enu;
      rect.u_in_enu = enu_from_street.rotation * rect.u_in_enu;
      rect.v_in_enu = enu_from_street.rotation * rect.v_in_enu;
    }
    return std::move(rects_);
  }

 private:
  std::vector<TexturedRect> rects_;
};

// Adds bay windows, balconies or columns to a house that starts at `a0` and whose front is at `o`.
void AddRelief(const HouseStyle& style, const FrontFrame& frame, double a0, double width, double o,
               cv::RNG* rng, StreetBuilder* builder) {
  const double upper_m = style.num_floors * style.floor_m;
  const int kind = rng->uniform(0, 4);
  if (kind == 0 && style.num_floors > 1) {  // Bay windows.
    const double bay_width = 2.6, height = std::floor(0.75 * style.num_floors) * style.floor_m;
    const double depth = rng->uniform(0.6, 1.0);
    const BoxTextures textures = {PaintBay(style, bay_width, height, rng).ToTexture(),
                                  PaintWall(style, depth, height, rng).ToTexture(),
                                  PaintWall(style, bay_width, depth, rng).ToTexture()};
    for (const double share : {0.25, 0.75}) {
      const double a = a0 + share * width - 0.5 * bay_width;
      builder->AddBox(
          frame,
          {a, a + bay_width, o, o + depth, style.ground_floor_m, style.ground_floor_m + height},
          textures);
    }
  } else if (kind == 1) {  // Balconies.
    const double balcony_width = rng->uniform(2.0, 3.2), depth = 0.9;
    const BoxTextures textures = {PaintRailing(balcony_width, 1.0, rng).ToTexture(),
                                  PaintRailing(depth, 1.0, rng).ToTexture(),
                                  PaintWall(style, balcony_width, depth, rng).ToTexture()};
    for (int floor = 0; floor < style.num_floors; ++floor) {
      const double a = a0 + (floor % 2 ? 0.7 : 0.3) * width - 0.5 * balcony_width;
      const double z = style.ground_floor_m + floor * style.floor_m;
      builder->AddBox(frame, {a, a + balcony_width, o, o + depth, z - 0.1, z + 0.9}, textures);
    }
  } else if (kind == 2) {  // Columns.
    const double side = 0.45, height = style.ground_floor_m + upper_m;
    const TexturePtr texture = PaintWall(style, side, height, rng).ToTexture();
    const int num_columns = std::max(2, static_cast<int>(width / 3.2));
    for (int i = 0; i < num_columns; ++i) {
      const double a = a0 + (width - side) * i / (num_columns - 1);
      builder->AddBox(frame, {a, a + side, o, o + 0.35, 0.0, height}, {texture, texture, nullptr});
    }
  }
  // Every house has a cornice under the roof.
  const TexturePtr cornice = PaintRailing(width, 0.35, rng).ToTexture();
  const double z = style.height_m() - 0.45;
  const TexturePtr soffit = PaintWall(style, width, 0.45, rng).ToTexture();
  builder->AddBox(frame, {a0, a0 + width, o, o + 0.45, z, z + 0.35}, {cornice, soffit, soffit});
}

// Adds houses side by side over `length` meters of a front.
void AddHouseRow(const FrontFrame& frame, double length, cv::RNG* rng, StreetBuilder* builder) {
  HouseStyle style = RandomHouseStyle(rng);
  for (double a = 0.0; a < length;) {
    double width = rng->uniform(9.0, 15.0);
    if (length - a - width < 6.0) {
      width = length - a;
    }
    // Some neighbors are built alike: the hardest case of aliasing.
    if (rng->uniform(0.0, 1.0) > 0.25) {
      style = RandomHouseStyle(rng);
    }
    const double setback = rng->uniform(0.0, 0.7);
    const double height = style.height_m();
    const BoxTextures textures = {PaintFacade(style, width, rng).ToTexture(),
                                  PaintWall(style, kHouseDepthM, height, rng).ToTexture(), nullptr};
    builder->AddBox(frame, {a, a + width, -setback - kHouseDepthM, -setback, 0.0, height},
                    textures);
    AddRelief(style, frame, a, width, -setback, rng, builder);
    a += width;
  }
}

// Adds kiosks at the walls, and advertising columns and signs along the curb of one pavement.
void AddFurniture(const FrontFrame& frame, double length, cv::RNG* rng, StreetBuilder* builder) {
  for (double a = rng->uniform(8.0, 16.0); a + 4.0 < length; a += rng->uniform(17.0, 26.0)) {
    const TexturePtr front = PaintPosters(2.0, 2.4, rng).ToTexture();
    const TexturePtr side = PaintPosters(1.2, 2.4, rng).ToTexture();
    const TexturePtr roof = PaintRailing(2.0, 1.2, rng).ToTexture();
    builder->AddBox(frame, {a, a + 2.0, 0.0, 1.2, 0.0, 2.4}, {front, side, roof});
  }
  for (double a = rng->uniform(6.0, 18.0); a < length - 5.0; a += rng->uniform(24.0, 36.0)) {
    const TexturePtr front = PaintPosters(0.9, 2.7, rng).ToTexture();
    const TexturePtr side = PaintPosters(0.9, 2.7, rng).ToTexture();
    builder->AddBox(frame, {a, a + 0.9, kSidewalkM - 1.0, kSidewalkM - 0.1, 0.0, 2.7},
                    {front, side, nullptr});
    builder->AddRect(frame.Point(a + 0.9, kSidewalkM - 1.0, 2.7), -0.9 * frame.Right(),
                     -2.7 * Eigen::Vector3d::UnitZ(), front);
  }
  for (double a = rng->uniform(2.0, 8.0); a < length - 2.0; a += rng->uniform(9.0, 15.0)) {
    const TexturePtr pole = PaintRailing(0.12, 3.4, rng).ToTexture();
    const TexturePtr sign = PaintSign(0.9, 0.7, rng).ToTexture();
    const double o = kSidewalkM - 0.3;
    builder->AddBox(frame, {a, a + 0.12, o - 0.12, o, 0.0, 3.4}, {pole, pole, nullptr});
    // The sign faces both ways along the street, just off its pole.
    const Eigen::Vector3d down = -0.7 * Eigen::Vector3d::UnitZ();
    builder->AddRect(frame.Point(a - 0.02, o - 0.5, 3.3), 0.9 * frame.out_in_street, down, sign);
    builder->AddRect(frame.Point(a + 0.14, o + 0.4, 3.3), -0.9 * frame.out_in_street, down, sign);
  }
}

// Plants trees along the curb of one pavement, in the street frame.
void PlantTrees(const FrontFrame& frame, const StreetOptions& options, TreePlanter* planter,
                std::vector<TexturedRect>* rects) {
  for (int i = 0; i < options.num_trees; ++i) {
    const double a = (i + 0.5) * options.length_m / options.num_trees;
    planter->Plant(frame.Point(a, kSidewalkM - 0.6, 0.0), rects);
  }
}

}  // namespace

Rigid3d EnuFromStreet(const StreetOptions& options) {
  const Eigen::Quaterniond rotation(
      Eigen::AngleAxisd(options.heading_rad, Eigen::Vector3d::UnitZ()));
  return {rotation, rotation * Eigen::Vector3d(-0.5 * options.length_m, 0.0, 0.0)};
}

std::vector<TexturedRect> BuildStreet(const StreetOptions& options) {
  cv::RNG rng(options.seed * 0x9E3779B97F4A7C15ull + 1);
  const double length = options.length_m, half_width = 0.5 * options.width_m;
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY();
  const FrontFrame left = {half_width * y, -y};
  const FrontFrame right = {length * x - half_width * y, y};
  const FrontFrame far_end = {length * x + half_width * y, -x};
  const FrontFrame near_end = {-half_width * y, x};

  StreetBuilder builder;
  AddHouseRow(left, length, &rng, &builder);
  AddHouseRow(right, length, &rng, &builder);
  AddHouseRow(far_end, options.width_m, &rng, &builder);
  AddHouseRow(near_end, options.width_m, &rng, &builder);
  AddFurniture(left, length, &rng, &builder);
  AddFurniture(right, length, &rng, &builder);
  // The ground is a meter wider than the street on each side, so that it reaches below houses that
  // are set back.
  const TexturePtr ground =
      PaintGround(length + 2.0, options.width_m + 2.0, kSidewalkM + 1.0, &rng).ToTexture();
  builder.AddRect(Eigen::Vector3d(-1.0, half_width + 1.0, 0.0), (length + 2.0) * x,
                  -(options.width_m + 2.0) * y, ground);
  if (options.num_trees > 0) {
    // Trees use their own random numbers, so that the street behind them equals the street without
    // trees.
    TreePlanter planter(options.seed);
    PlantTrees(left, options, &planter, builder.rects());
    PlantTrees(right, options, &planter, builder.rects());
  }
  return std::move(builder).Finish(EnuFromStreet(options));
}

}  // namespace cairn
