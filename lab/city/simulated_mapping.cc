#include "lab/city/simulated_mapping.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "core/angles.h"
#include "core/geodesy.h"
#include "lab/city/camera_angles.h"
#include "lab/city/hashed_random.h"
#include "lab/city/mapping_streams.h"

namespace cairn {
namespace {

constexpr double kDeformationWaveM = 300.0;
constexpr double kDriftWaveM = 80.0;
constexpr double kParkedCarM = 2.0;
constexpr double kMinLaneOffsetM = 0.5, kMaxLaneOffsetM = 1.9;
constexpr double kSwayM = 0.2;  // The car's deviation from its lane.
constexpr double kHeadingSigmaRad = 0.02;
constexpr double kSearchBoxM = 300.0;

}  // namespace

SimulatedMapping::SimulatedMapping(const City& city, const DescriptorModel& model,
                                   const SimulatedMappingOptions& options)
    : city_(city),
      model_(model),
      options_((options.Validate(), options)),
      deformation_(HashOf(options.seed, kDeformationStream), options.noise.deformation_m,
                   kDeformationWaveM) {
  for (int pass = 0; pass < options_.num_passes; ++pass) {
    drift_.emplace_back(HashOf(options_.seed, kDriftStream, pass), options_.noise.pass_drift_m,
                        kDriftWaveM);
  }
}

Sim3d SimulatedMapping::EcefFromWorld() const {
  return {1.0, city_.ecef_from_site().rotation, city_.ecef_from_site().translation};
}

std::vector<TileId> SimulatedMapping::Tiles() const {
  const double side_m = city_.options().SideM();
  const int num_steps = static_cast<int>(std::ceil(side_m / kSearchBoxM));
  const double step_m = side_m / num_steps;
  std::set<TileId> found;
  for (int pass = 0; pass < options_.num_passes; ++pass) {
    for (int i = 0; i < num_steps * num_steps; ++i) {
      const Eigen::Vector2d low(-0.5 * side_m + step_m * (i % num_steps),
                                -0.5 * side_m + step_m * (i / num_steps));
      const CityBox box(low, low + Eigen::Vector2d(step_m, step_m));
      for (const RigKeyframe& keyframe : KeyframesIn(box, pass)) {
        found.insert(TileAt(city_, keyframe.center_in_site));
      }
    }
  }
  std::vector<std::pair<double, TileId>> by_distance;
  for (const TileId tile_id : found) {
    by_distance.emplace_back(GroundDistanceM(city_.options().center, tile_id.Anchor()), tile_id);
  }
  std::sort(by_distance.begin(), by_distance.end());
  std::vector<TileId> tiles;
  for (const auto& [distance_m, tile_id] : by_distance) {
    tiles.push_back(tile_id);
  }
  return tiles;
}

std::vector<RigKeyframe> SimulatedMapping::KeyframesIn(const CityBox& box, int pass) const {
  std::vector<RigKeyframe> keyframes;
  for (const CityStreet& street : city_.StreetsIn(box)) {
    const double road_m = street.width_m - 2.0 * (street.sidewalk_m + kParkedCarM);
    const double lane_m = std::clamp(0.25 * road_m, kMinLaneOffsetM, kMaxLaneOffsetM);
    const double length_m = street.LengthM();
    for (const int way : {1, -1}) {
      HashedRandom lane(HashOf(options_.seed, kLaneStream, street.id, pass, way + 1));
      if (!lane.Chance(options_.lane_share)) {
        continue;
      }
      const double first_m = lane.Uniform(0.0, options_.keyframe_spacing_m);
      const double sway_phase = lane.Uniform(0.0, 2.0 * kPi);
      for (int k = 0; first_m + k * options_.keyframe_spacing_m < length_m; ++k) {
        const double along_m = first_m + k * options_.keyframe_spacing_m;
        const double sway_m = kSwayM * std::sin(0.1 * along_m + sway_phase);
        // Cars drive on the right.
        const Eigen::Vector2d at = street.At(along_m, sway_m - way * lane_m);
        if (!box.contains(at) || !city_.Contains(at)) {
          continue;
        }
        RigKeyframe keyframe;
        keyframe.id = HashOf(options_.seed, kKeyframeStream, street.id, pass, way + 1, k);
        keyframe.pass = pass;
        keyframe.center_in_site << at, city_.GroundM(at) + options_.rig.height_m;
        const Eigen::Vector2d direction = way * street.Direction();
        keyframe.heading_rad = std::atan2(direction.y(), direction.x()) +
                               kHeadingSigmaRad * HashedRandom(keyframe.id).Normal();
        keyframes.push_back(keyframe);
      }
    }
  }
  return keyframes;
}

double SimulatedMapping::ExpectedObservations() const {
  // A block accounts for two of its four streets.
  const CityShape& shape = city_.shape();
  const double street_m_per_sqm =
      (shape.pitch_x_m + shape.pitch_y_m) / (shape.pitch_x_m * shape.pitch_y_m);
  const double street_m = street_m_per_sqm * city_.options().area_km2 * 1e6;
  const double num_keyframes =
      2.0 * street_m * options_.lane_share * options_.num_passes / options_.keyframe_spacing_m;
  return num_keyframes * options_.rig.num_cameras * options_.detector.max_keypoints *
         (1.0 + options_.clutter_ratio);
}

}  // namespace cairn
