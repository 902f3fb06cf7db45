#include "eval/pictures/plan_content.h"

#include <algorithm>
#include <utility>

#include "core/error.h"
#include "core/geodesy.h"
#include "storage/tile/tile_codec.h"

namespace cairn {
namespace {

constexpr int kMaxTiles = 64;             // Maximum number decoded for one picture.
constexpr double kSearchRadiusM = 200.0;  // Distance between a pose and the tiles drawn.
constexpr double kMarginM = 12.0;
constexpr double kMaxDrawnAccuracyM = 100.0;

std::vector<Eigen::Vector3d> PositionsInEcef(const std::vector<TopViewPose>& poses) {
  std::vector<Eigen::Vector3d> positions;
  for (const TopViewPose& pose : poses) {
    for (const auto& cam_from_ecef : {pose.reference_cam_from_ecef, pose.estimated_cam_from_ecef}) {
      if (cam_from_ecef) {
        positions.push_back(cam_from_ecef->Inverse().translation);
      }
    }
    if (pose.prior) {
      positions.push_back(EcefFromGeodetic(*pose.prior));
    }
  }
  return positions;
}

// The tiles near the poses; without poses, the first tiles of the map.
std::vector<TileRecord> TilesToDraw(const MapSnapshot& map,
                                    const std::vector<Eigen::Vector3d>& positions_in_ecef) {
  std::vector<TileRecord> tiles;
  if (positions_in_ecef.empty()) {
    return map.AllTiles(kMaxTiles);
  }
  for (const Eigen::Vector3d& position : positions_in_ecef) {
    const GeoBox box = BoxAround(GeodeticFromEcef(position), kSearchRadiusM);
    for (TileRecord& tile : map.FindTiles(box)) {
      tiles.push_back(std::move(tile));
    }
  }
  std::sort(tiles.begin(), tiles.end(),
            [](const TileRecord& p, const TileRecord& q) { return p.tile_id < q.tile_id; });
  tiles.erase(
      std::unique(tiles.begin(), tiles.end(),
                  [](const TileRecord& p, const TileRecord& q) { return p.tile_id == q.tile_id; }),
      tiles.end());
  tiles.resize(std::min(tiles.size(), static_cast<size_t>(kMaxTiles)));
  return tiles;
}

// The center of the drawn area, at ground level.
Geodetic PlanOrigin(const std::vector<TileRecord>& tiles,
                    const std::vector<Eigen::Vector3d>& positions_in_ecef) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& position : positions_in_ecef) {
    sum += position;
  }
  if (!positions_in_ecef.empty()) {
    return GeodeticFromEcef(sum / static_cast<double>(positions_in_ecef.size()));
  }
  if (tiles.empty()) {
    throw Error(ErrorCode::kBadInput, "there is nothing to draw: no poses and an empty map");
  }
  Geodetic origin = tiles.front().tile_id.Anchor();
  origin.h_m = tiles.front().min_h_m;
  return origin;
}

void AddTile(const TileRecord& record, const Tile& tile, PlanContent* content) {
  PlanTile plan_tile;
  plan_tile.name = record.tile_id.ToString();
  for (const Geodetic& corner : record.tile_id.Corners()) {
    // The corners have height 0; the plan needs their positions at its own height.
    const Geodetic raised = {corner.lat_rad, corner.lon_rad, record.min_h_m};
    plan_tile.corners.push_back((content->plan_from_ecef * EcefFromGeodetic(raised)).head<2>());
  }
  content->tiles.push_back(std::move(plan_tile));
  const Rigid3d plan_from_tile = content->plan_from_ecef * EcefFromEnu(record.tile_id.Anchor());
  for (const Eigen::Vector3f& x_in_tile : tile.x_in_tile) {
    content->landmarks.push_back(plan_from_tile * x_in_tile.cast<double>());
  }
  for (const TileKeyframe& keyframe : tile.keyframes) {
    content->keyframes.push_back(OnPlan(keyframe.cam_from_tile * plan_from_tile.Inverse()));
  }
}

// The area of poses, priors with their circles, and keyframes. If there are none, the area of the
// tiles.
PlanArea AreaToDraw(const PlanContent& content, const std::vector<TopViewPose>& poses,
                    const std::vector<Eigen::Vector3d>& positions_in_ecef) {
  std::vector<Eigen::Vector2d> points;
  for (const Eigen::Vector3d& position : positions_in_ecef) {
    points.push_back((content.plan_from_ecef * position).head<2>());
  }
  for (const PlanPose& keyframe : content.keyframes) {
    points.push_back(keyframe.center);
  }
  if (points.empty()) {
    for (const PlanTile& tile : content.tiles) {
      points.insert(points.end(), tile.corners.begin(), tile.corners.end());
    }
  }
  PlanArea area = AreaAround(points, kMarginM);
  for (const TopViewPose& pose : poses) {
    if (pose.prior) {
      const Eigen::Vector2d prior =
          (content.plan_from_ecef * EcefFromGeodetic(*pose.prior)).head<2>();
      area = Union(area, AreaAround({prior}, std::min(pose.prior_accuracy_m, kMaxDrawnAccuracyM)));
    }
  }
  return area;
}

void FindHeightRange(PlanContent* content) {
  std::vector<double> heights_m;
  for (const Eigen::Vector3d& landmark : content->landmarks) {
    heights_m.push_back(landmark.z());
  }
  if (heights_m.empty()) {
    return;
  }
  std::sort(heights_m.begin(), heights_m.end());
  content->low_m = heights_m[heights_m.size() / 50];
  content->high_m = std::max(content->low_m + 1.0, heights_m[(heights_m.size() - 1) * 49 / 50]);
}

}  // namespace

PlanContent LoadPlanContent(const MapSnapshot& map, const std::vector<TopViewPose>& poses) {
  const std::vector<Eigen::Vector3d> positions_in_ecef = PositionsInEcef(poses);
  const std::vector<TileRecord> tiles = TilesToDraw(map, positions_in_ecef);
  PlanContent content;
  content.plan_from_ecef = EcefFromEnu(PlanOrigin(tiles, positions_in_ecef)).Inverse();
  for (const TileRecord& record : tiles) {
    AddTile(record, DecodeTile(map.LoadPayload(record.payload_id)), &content);
  }
  content.area = AreaToDraw(content, poses, positions_in_ecef);
  FindHeightRange(&content);
  return content;
}

}  // namespace cairn
