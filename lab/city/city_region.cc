#include "lab/city/city_region.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace cairn {
namespace {

constexpr double kCellM = 10.0;
constexpr double kOwnWallM = 0.2;

}  // namespace

CityRegion::CityRegion(const City& city, const CityBox& box, double time_years)
    : time_years_(time_years) {
  for (CitySurface& surface : SurfacesIn(city, box, time_years)) {
    RegionSurface entry;
    entry.middle = surface.MiddleInPlan();
    entry.radius_m = surface.RadiusInPlanM();
    entry.landmarks = LandmarksOn(city, surface, time_years);
    entry.surface = std::move(surface);
    num_landmarks_ += static_cast<int64_t>(entry.landmarks.size());
    surfaces_.push_back(std::move(entry));
  }
  const std::vector<CityBuilding> buildings = city.BuildingsIn(box);
  for (const CityBuilding& building : buildings) {
    for (const Eigen::Vector2d& corner : building.corners) {
      grid_bounds_.extend(corner);
    }
  }
  if (buildings.empty()) {
    return;
  }
  num_columns_ = static_cast<int>(grid_bounds_.sizes().x() / kCellM) + 1;
  num_rows_ = static_cast<int>(grid_bounds_.sizes().y() / kCellM) + 1;
  cells_.resize(static_cast<size_t>(num_columns_) * static_cast<size_t>(num_rows_));
  for (const CityBuilding& building : buildings) {
    AddBlock(building);
  }
}

void CityRegion::AddBlock(const CityBuilding& building) {
  Block block;
  block.top_m = building.top_m;
  CityBox bounds;
  for (int k = 0; k < 4; ++k) {
    const Eigen::Vector2d& corner = building.corners[k];
    const Eigen::Vector2d side = building.corners[(k + 1) % 4] - corner;
    block.normals[k] = Eigen::Vector2d(side.y(), -side.x()).normalized();
    block.offsets[k] = block.normals[k].dot(corner);
    bounds.extend(corner);
  }
  const auto index = static_cast<uint32_t>(blocks_.size());
  blocks_.push_back(block);
  const Eigen::Vector2i low = ((bounds.min() - grid_bounds_.min()) / kCellM).cast<int>();
  const Eigen::Vector2i high = ((bounds.max() - grid_bounds_.min()) / kCellM).cast<int>();
  for (int row = low.y(); row <= high.y(); ++row) {
    for (int column = low.x(); column <= high.x(); ++column) {
      cells_[CellOf(column, row)].push_back(index);
    }
  }
}

bool CityRegion::Block::Hides(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const {
  double enter = 0.0, leave = 1.0;
  const Eigen::Vector2d way = (to - from).head<2>();
  for (int k = 0; k < 4; ++k) {
    const double distance = offsets[k] - normals[k].dot(from.head<2>());
    const double speed = normals[k].dot(way);
    if (speed == 0.0) {
      if (distance < 0.0) {
        return false;
      }
    } else if (speed > 0.0) {
      leave = std::min(leave, distance / speed);
    } else {
      enter = std::max(enter, distance / speed);
    }
    if (enter >= leave) {
      return false;
    }
  }
  const double rise = to.z() - from.z();
  return from.z() + std::min(enter * rise, leave * rise) < top_m;
}

bool CityRegion::IsHidden(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const {
  const double distance_m = (to - from).norm();
  if (distance_m <= kOwnWallM || blocks_.empty()) {
    return false;
  }
  const Eigen::Vector3d end = to - kOwnWallM / distance_m * (to - from);
  // Visits the cells along the line (Amanatides and Woo 1987).
  const Eigen::Vector2d start = (from.head<2>() - grid_bounds_.min()) / kCellM;
  const Eigen::Vector2d way = (end - from).head<2>() / kCellM;
  Eigen::Vector2i cell(static_cast<int>(std::floor(start.x())),
                       static_cast<int>(std::floor(start.y())));
  Eigen::Vector2i step;
  Eigen::Vector2d next, delta;
  for (int axis = 0; axis < 2; ++axis) {
    step[axis] = way[axis] >= 0.0 ? 1 : -1;
    const double border = cell[axis] + (way[axis] >= 0.0 ? 1 : 0);
    const bool moves = std::abs(way[axis]) > 1e-12;
    next[axis] =
        moves ? (border - start[axis]) / way[axis] : std::numeric_limits<double>::infinity();
    delta[axis] = moves ? 1.0 / std::abs(way[axis]) : std::numeric_limits<double>::infinity();
  }
  for (double at = 0.0; at <= 1.0;) {
    if (cell.x() >= 0 && cell.y() >= 0 && cell.x() < num_columns_ && cell.y() < num_rows_) {
      for (const uint32_t index : cells_[CellOf(cell.x(), cell.y())]) {
        if (blocks_[index].Hides(from, end)) {
          return true;
        }
      }
    }
    const int axis = next.x() < next.y() ? 0 : 1;
    at = next[axis];
    next[axis] += delta[axis];
    cell[axis] += step[axis];
  }
  return false;
}

}  // namespace cairn
