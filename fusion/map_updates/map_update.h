// Updates the filter from matches to the map, as in the paper's section "Global Updates to the
// Local State Estimation". The matches are compressed clone by clone.
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

// Gate on each match, given as a quantile of the standard normal distribution; passes 99 %.
inline constexpr double kMatchGateQuantile = 2.326;
inline constexpr int kMinMapMatches = 8;  // Fewest matches of a response that must pass.
inline constexpr double kMinMapInlierFraction = 0.35;  // Share of its matches that must pass.

struct MapUpdateOptions {
  double sigma_px = 1.0;  // Standard deviation of a matched keypoint per axis.
  // Prior standard deviation of the tilt between local and global at the first alignment. If
  // positive, the filter also estimates the tilt. 0: both frames are level (4 degrees of freedom).
  double tilt_sigma_rad = 0.0;

  int num_global_dims() const { return tilt_sigma_rad > 0.0 ? 6 : 4; }
  void Validate() const;
};

// One observation of a map landmark at one clone.
struct MapObservation {
  // Observations of one match share this number and are adjacent. The first of them is the queried
  // observation.
  int match = 0;
  int clone = 0;  // The clone that took the observation.
  Eigen::Vector2d pixel;
  Eigen::Vector3d x_in_global;
  // Standard deviation of the landmark per axis. If M clones saw the landmark, each observation
  // gets sqrt(M) times the map's value. Together the observations then say no more about the
  // landmark than the map knows, and no dense covariance among them is needed.
  double sigma_m = 0.0;
  uint64_t tile_id = 0;
};

// A linearized and whitened observation.
struct MapRows {
  int clone = 0;
  uint64_t tile_id = 0;
  Eigen::Matrix<double, 2, kCloneDim> by_clone;
  Eigen::Matrix<double, 2, kGlobalDim> by_global;
  Eigen::Matrix<double, 2, kTileDim> by_tile;
  Eigen::Matrix<double, 2, kRigDim> by_rig;
  Eigen::Vector2d residual;
};

// Returns nullopt if the landmark does not project into the image. `views[i]` belongs to clone i.
std::optional<MapRows> LinearizeObservation(const Camera& camera, const Rig& rig,
                                            std::span<const CameraView> views,
                                            const Rigid3d& global_from_local,
                                            const MapObservation& observation, double sigma_px);

// Combines all rows into one measurement with few rows. A row touches the six columns of its clone
// and the columns that all clones share. Each clone's rows are therefore triangularized alone; the
// rows below the clone's own columns touch only the shared columns and are triangularized once
// more. Blocks, in order: global_from_local (num_global_dims), the rig if estimated, the tiles that
// `state` has, the clones.
Measurement CompressMapRows(const std::vector<MapRows>& rows, int num_global_dims,
                            const FilterState& state);

// Makes room in `state` for the tiles of the observations, if `state` models tile offsets.
void AddTiles(std::span<const MapObservation> observations, FilterState* state);

enum class MapUpdateStatus {
  kApplied,
  kTooFewMatches,  // Fewer than kMinMapMatches project and pass their gates.
  kDisagrees,      // Most matches, or all together, contradict the state.
};

struct MapUpdateResult {
  MapUpdateStatus status = MapUpdateStatus::kApplied;
  int num_matches = 0;                  // Matches that were applied.
  int num_gated = 0;                    // Matches that their own gate rejected.
  std::vector<bool> used_observations;  // One entry per observation; all false unless applied.
};

// Gates and applies the matches of one response. `state` must be aligned, and changes only if the
// returned status is kApplied.
MapUpdateResult UpdateFromMap(const Camera& camera, std::span<const MapObservation> observations,
                              const MapUpdateOptions& options, FilterState* state);

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_MAP_UPDATES_MAP_UPDATE_H_
