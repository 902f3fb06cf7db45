// The parts of a map that a top view shows.
#ifndef CAIRN_EVAL_PICTURES_PLAN_CONTENT_H_
#define CAIRN_EVAL_PICTURES_PLAN_CONTENT_H_

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/rigid3.h"
#include "eval/pictures/pictures.h"
#include "eval/pictures/plan_symbols.h"
#include "eval/pictures/plan_view.h"
#include "storage/map/map_store.h"

namespace cairn {

struct PlanTile {
  std::string name;
  std::vector<Eigen::Vector2d> corners;
};

// All positions are in the plan frame: east-north-up at the center of the drawn area.
struct PlanContent {
  Rigid3d plan_from_ecef;
  std::vector<PlanTile> tiles;
  std::vector<Eigen::Vector3d> landmarks;
  std::vector<PlanPose> keyframes;
  PlanArea area;  // Holds poses, priors and keyframes.
  // Heights above the plan's origin; nearly all landmarks lie between them.
  double low_m = 0.0, high_m = 1.0;
};

// Loads the tiles near the poses; without poses, the first tiles of the map. Decodes at most 64
// tiles. Throws Error(kBadInput) if there are neither poses nor tiles, and Error(kMapDamaged) as
// DecodeTile.
PlanContent LoadPlanContent(const MapSnapshot& map, const std::vector<TopViewPose>& poses);

}  // namespace cairn

#endif  // CAIRN_EVAL_PICTURES_PLAN_CONTENT_H_
