// The state of the filter, its covariance, and everything that is ever done to the covariance.
//
// Error state, in this order (docs/math/fusion.md):
//   imu        15  theta, p, v, b_g, b_a
//   global      6  rho, psi, tilt x, tilt y of global_from_local; zero variance where not estimated
//   rig         7  phi, p of cam_from_imu, and the time offset; only if one of them is estimated
//   tiles     3 K  offset of each of K map tiles in global; only with tile_sigma_m > 0
//   points    3 M  long-lived points, each in a chart at a clone; zero variance where there is none
//   clones    6 N  theta, p of past poses of the imu
#ifndef CAIRN_FUSION_FILTER_FILTER_STATE_H_
#define CAIRN_FUSION_FILTER_FILTER_STATE_H_

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/rigid3.h"
#include "fusion/filter/imu.h"
#include "fusion/filter/imu_propagation.h"
#include "fusion/filter/measurement.h"
#include "fusion/filter/point_chart.h"

namespace cairn::fusion {

inline constexpr int kCloneDim = 6;
inline constexpr int kGlobalDim = 6;
inline constexpr int kRigDim = 7;
inline constexpr int kTileDim = 3;
inline constexpr int kMaxClones = 24;
inline constexpr int kMaxTiles = 8;
inline constexpr int kPointDim = 3;
inline constexpr int kMaxPoints = 64;

inline constexpr int kGlobalIdx = kImuDim;  // rho; psi follows at + 3, tilt at + 4.
inline constexpr int kRigIdx = kGlobalIdx + kGlobalDim;

// A past pose of the imu, kept because measurements of its instant are still to come.
struct Clone {
  int64_t frame_id = 0;
  int64_t timestamp_ns = 0;
  Rigid3d local_from_imu;
  // Estimate when the clone was made. Jacobians by rotations are linearised here for as long as the
  // clone lives (first-estimate Jacobians).
  Eigen::Vector3d first_position_in_local = Eigen::Vector3d::Zero();
};

// A tracked point that stays in the state for as long as it is in view.
struct StatePoint {
  uint64_t track_id = 0;
  int anchor = 0;               // The clone in whose imu frame the chart is.
  PointChart chart;             // Made for the point's first estimate.
  Eigen::Vector3d coordinates;  // In the chart, the present estimate.
  bool contradicted = false;    // By its newest sight.
};

// Where a point of the state is, and how that depends on the state. The derivatives are those at
// the point's first estimate, which moves with the anchor: at estimates that change from sight to
// sight, the sights would together tell the scale of the way, which none of them sees.
struct LocatedPoint {
  Eigen::Vector3d x_in_local;
  Eigen::Vector3d first_x_in_local;
  Eigen::Matrix<double, kPointDim, kCloneDim> by_anchor;
  Eigen::Matrix3d by_coordinates;
};

// What a track says about its point: by_point * (error of the point) + clones.jacobian * (error of
// the state at clones.blocks) + noise = clones.residual, three rows, the noise white.
struct PointRows {
  Eigen::Vector3d x_in_local;  // Linearised at.
  Eigen::Matrix3d by_point;    // Upper triangular.
  Measurement clones;
};

// Mounting of the camera on the imu.
struct Rig {
  Rigid3d cam_from_imu;
  double time_offset_s = 0.0;  // Time of the imu minus time of the camera, for the same instant.
};

struct FilterStateOptions {
  // Prior standard deviations of the rig; 0: taken as exact, not estimated.
  double extrinsic_rotation_sigma_rad = 0.0;
  double extrinsic_translation_sigma_m = 0.0;
  double time_offset_sigma_s = 0.0;
  // Standard deviation per axis of the offset that all landmarks of one tile share; 0: no such
  // variable. With it, the map is never corrected but its uncertainty is accounted for (Schmidt).
  double tile_sigma_m = 0.0;
  // Tracked points that stay in the state while they are in view, in [0, kMaxPoints]; 0: none.
  int max_points = 30;

  void Validate() const;
};

// What a measurement changes, before it does.
struct Correction {
  Eigen::VectorXd error;  // Of the mean.
  Eigen::MatrixXd gain;   // The covariance loses gain' gain, but for the offsets of tiles.
};

// Not thread-safe. Of fixed size: no call allocates in proportion to anything but the measurement.
class FilterState {
 public:
  // `covariance` is that of `imu`.
  FilterState(const ImuState& imu, const Matrix15d& covariance, const Rig& rig,
              const FilterStateOptions& options);

  const ImuState& imu() const { return mean_.imu; }
  const FirstEstimate& first() const { return first_; }
  const Rig& rig() const { return mean_.rig; }
  // Nothing until InitializeGlobal.
  const std::optional<Rigid3d>& global_from_local() const { return mean_.global_from_local; }
  const std::vector<Clone>& clones() const { return mean_.clones; }  // By time.

  int dim() const { return clones_idx_ + kCloneDim * static_cast<int>(mean_.clones.size()); }
  int CloneIdx(int clone) const { return clones_idx_ + kCloneDim * clone; }
  bool estimates_rig() const { return estimates_rig_; }
  auto covariance() const { return covariance_.topLeftCorner(dim(), dim()); }

  // Moves the imu to `end`; `first` and `transition` as Propagate() made them on the way.
  void Propagate(const ImuState& end, const FirstEstimate& first, const ImuTransition& transition);

  // Stochastic cloning of the present pose, which the camera took. `imu_rate_rad_s` is the
  // bias-free angular rate, for the time offset. There must be fewer than kMaxClones.
  void AddClone(int64_t frame_id, int64_t timestamp_ns, const Eigen::Vector3d& imu_rate_rad_s);

  // Marginalises a clone. Points that are anchored there are anchored at the newest other one.
  void RemoveClone(int clone);

  // Offset into the error state of the nuisance of a tile, made on first use in place of the one
  // longest unused. Must only be called with tile_sigma_m > 0.
  int TileIdx(uint64_t tile_id);
  // As above, or nothing if the tile has none.
  std::optional<int> FindTileIdx(uint64_t tile_id) const;
  bool has_tiles() const { return tile_sigma_m_ > 0.0; }
  double tile_sigma_m() const { return tile_sigma_m_; }

  // By slot; nothing in free ones.
  const std::vector<std::optional<StatePoint>>& points() const { return mean_.points; }
  int PointIdx(int slot) const { return points_idx_ + kPointDim * slot; }

  LocatedPoint Locate(int slot) const;

  // Enters a point into a free slot with exact correlations, anchored at the newest clone. False,
  // with nothing changed, if the rows leave it undetermined.
  bool EnterPoint(int slot, uint64_t track_id, const PointRows& rows);

  // Frees a slot.
  void RemovePoint(int slot);

  void SetContradicted(int slot, bool contradicted) {
    mean_.points[static_cast<size_t>(slot)]->contradicted = contradicted;
  }

  // Squared Mahalanobis distance of the residual.
  double SquaredMahalanobis(const Measurement& measurement) const;

  // Kalman update. Returns false and changes nothing if the innovation covariance is not finite and
  // positive. The offsets of tiles are considered, not updated.
  bool Update(const Measurement& measurement) { return Update({&measurement, 1}); }
  // As one measurement of all the rows, each part touching its own blocks only.
  bool Update(std::span<const Measurement> parts);

  // The two steps of Update: nothing if the innovation covariance is not finite and positive.
  std::optional<Correction> Solve(std::span<const Measurement> parts) const;
  void Apply(const Correction& correction);

  // Kalman update with what `linearize(*this)` (-> Measurement, its residuals compressed or not)
  // says. Where the correction is so large that the linearisation is in doubt (2 cm or 3 mrad at
  // some clone), the measurement is linearised again where the correction leads, at most twice: an
  // iterated Kalman update (Bell and Cathey 1993). Returns as Update.
  template <typename Linearize>
  bool IteratedUpdate(const Linearize& linearize);

  // Enters global_from_local, linearised at `global_from_local`, from a measurement whose first
  // block is {kGlobalIdx, num_global_dims}; the rows beyond those that determine it update the
  // state. Correlations with the clones (and tiles) the measurement saw are exact. False, with
  // nothing changed, if the measurement leaves it undetermined.
  bool InitializeGlobal(const Rigid3d& global_from_local, const Measurement& measurement);

  // Forgets global_from_local.
  void ForgetGlobal();

 private:
  struct Mean {
    ImuState imu;
    Rig rig;
    std::optional<Rigid3d> global_from_local;
    std::vector<Clone> clones;
    std::vector<std::optional<StatePoint>> points;
  };

  // P H': covariance between the whole state and the rows.
  Eigen::MatrixXd StateByRows(std::span<const Measurement> parts) const;
  static Eigen::MatrixXd InnovationCovariance(std::span<const Measurement> parts,
                                              const Eigen::MatrixXd& state_by_rows);
  void MoveMean(const Eigen::VectorXd& error);
  LocatedPoint Locate(const StatePoint& point) const;
  // Anchors a point at a clone, its first and its present estimate.
  void SetAnchor(int clone, const Eigen::Vector3d& first_x_in_local,
                 const Eigen::Vector3d& x_in_local, StatePoint* point) const;
  // The same, for a point of the state.
  void MoveAnchor(int slot, int clone);
  // Largest correction of a clone, in units of those beyond which a linearisation is in doubt.
  double LinearizationDoubt(const Eigen::VectorXd& error) const;
  // Enters a variable g at `offset` of which `top` says: by_variable * g + H x + n = r. Returns
  // by_variable^-1 r.
  Eigen::VectorXd EnterVariable(int offset, const Eigen::MatrixXd& by_variable,
                                const Measurement& top);

  Mean mean_;
  FirstEstimate first_;
  bool estimates_rig_;
  double tile_sigma_m_;
  int tiles_idx_;
  int points_idx_;
  int clones_idx_;
  struct TileSlot {
    std::optional<uint64_t> tile_id;
    int64_t last_use = 0;
  };
  std::array<TileSlot, kMaxTiles> tiles_;
  int64_t tile_clock_ = 0;
  Eigen::MatrixXd covariance_;  // Never resized.
};

template <typename Linearize>
bool FilterState::IteratedUpdate(const Linearize& linearize) {
  constexpr int kMaxIterations = 3;
  std::optional<Correction> correction;
  {
    const Measurement measurement = linearize(*this);
    correction = Solve({&measurement, 1});
  }
  if (!correction) {
    return false;
  }
  double doubt = LinearizationDoubt(correction->error);
  for (int i = 1; i < kMaxIterations && doubt > 1.0; ++i) {
    Mean prior = mean_;
    MoveMean(correction->error);
    Measurement again = linearize(*this);
    mean_ = std::move(prior);
    // About the prior mean again: r + H (x - x_prior).
    Eigen::Index column = 0;
    for (const StateBlock& block : again.blocks) {
      again.residual += again.jacobian.middleCols(column, block.size) *
                        correction->error.segment(block.offset, block.size);
      column += block.size;
    }
    std::optional<Correction> next = Solve({&again, 1});
    if (!next) {
      break;
    }
    doubt = LinearizationDoubt(next->error - correction->error);
    correction = std::move(next);
  }
  Apply(*correction);
  return true;
}

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_FILTER_FILTER_STATE_H_
