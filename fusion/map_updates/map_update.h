// Updates of the filter from matches to the map: "Global Updates to the Local State Estimation" of
// the paper, with compression by clone.
#ifndef CAIRN_FUSION_MAP_UPDATES_MAP_UPDATE_H_
#define CAIRN_FUSION_MAP_UPDATES_MAP_UPDATE_H_

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/camera.h"
#include "core/rigid3.h"
#include "fusion/filter/camera_view.h"
#include "fusion/filter/filter_state.h"

namespace cairn::fusion {

struct MapUpdateOptions {
  double sigma_px = 1.0;  // Standard deviation of a matched keypoint per axis.
  // Gate on each match, as the quantile of a standard normal variable; 2.326 passes 99 %.
  double match_gate_quantile = 2.326;
  // Gate on all that remains of a response; 3.72 passes 99.99 %, as a linearisation error of a part
  // of a pixel in hundreds of matches must not throw away a response.
  double response_gate_quantile = 3.72;
  int min_matches = 8;                // Of a response, after gating.
  double min_inlier_fraction = 0.35;  // Of the matches of a response that must pass their gate.
  // Estimate the tilt between local and global, too, with this standard deviation at the first
  // alignment; 0: both are level (4 degrees of freedom).
  double tilt_sigma_rad = 0.0;

  int num_global_dims() const { return tilt_sigma_rad > 0.0 ? 6 : 4; }
  void Validate() const;
};

// One sight of a landmark of the map.
struct MapSight {
  int match =
      0;  // Sights of one match share it and lie side by side; its first is the queried one.
  int clone = 0;  // Where it was taken.
  Eigen::Vector2d pixel;
  Eigen::Vector3d x_in_global;
  // Standard deviation of the landmark per axis. Of a landmark seen in M clones, each sight gets
  // sqrt(M) times that of the map: together they then say no more about it than the map knows,
  // without a dense covariance among them.
  double sigma_m = 0.0;
  uint64_t tile_id = 0;
};

// A sight linearised and whitened.
struct MapRows {
  int clone = 0;
  uint64_t tile_id = 0;
  Eigen::Matrix<double, 2, kCloneDim> by_clone;
  Eigen::Matrix<double, 2, kGlobalDim> by_global;
  Eigen::Matrix<double, 2, kTileDim> by_tile;
  Eigen::Matrix<double, 2, kRigDim> by_rig;
  Eigen::Vector2d residual;
};

// Nothing if the landmark does not project. `views[i]` belongs to clone i.
std::optional<MapRows> LinearizeSight(const Camera& camera, const Rig& rig,
                                      std::span<const CameraView> views,
                                      const Rigid3d& global_from_local, const MapSight& sight,
                                      double sigma_px);

// All rows as one measurement of few rows. A row touches the six columns of its clone and those
// that all share, so each clone's rows are triangularised alone; what remains below a clone's own
// columns touches the shared columns only and is triangularised again. Blocks: global_from_local
// (num_global_dims), the rig if estimated, the tiles that `state` has, the clones.
Measurement CompressMapRows(const std::vector<MapRows>& rows, int num_global_dims,
                            const FilterState& state);

// Makes room in `state` for the tiles of the sights, if it considers tiles.
void AddTiles(std::span<const MapSight> sights, FilterState* state);

enum class MapUpdateStatus {
  kApplied,
  kTooFewMatches,  // Fewer than min_matches that project and pass their gates.
  kDisagrees,      // Most matches, or all of them together, contradict the state.
};

struct MapUpdateResult {
  MapUpdateStatus status = MapUpdateStatus::kApplied;
  int num_matches = 0;            // That went in.
  int num_gated = 0;              // Matches rejected alone.
  std::vector<bool> used_sights;  // By sight; all false unless applied.
};

// Gates and applies the matches of one response. `state` must be aligned; it changes only if the
// status is kApplied.
MapUpdateResult UpdateFromMap(const Camera& camera, std::span<const MapSight> sights,
                              const MapUpdateOptions& options, FilterState* state);

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_MAP_UPDATES_MAP_UPDATE_H_
