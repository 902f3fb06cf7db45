// The filter's state and covariance. All changes to the covariance happen here.
//
// The error state consists of these blocks, in this order (docs/math/fusion.md):
//   imu        15  theta, p, v, b_g, b_a
//   global      6  rho, psi, tilt x, tilt y of global_from_local; zero variance if not estimated
//   rig         7  phi, p of cam_from_imu, and the time offset; only if one of them is estimated
//   tiles     3 K  offset of each of K map tiles in global; only with tile_sigma_m > 0
//   points    3 M  long-lived points, each in a chart at a clone; zero variance in free slots
//   clones    6 N  theta, p of past poses of the IMU
#ifndef CAIRN_FUSION_FILTER_FILTER_STATE_H_
#define CAIRN_FUSION_FILTER_FILTER_STATE_H_

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/inertial/imu.h"
#include "core/inertial/imu_propagation.h"
#include "core/rigid3.h"
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

// A past pose of the IMU, kept because measurements of its time are still to come.
struct Clone {
  int64_t frame_id = 0;
  int64_t timestamp_ns = 0;
  Rigid3d local_from_imu;
  // Position at the time the clone was made. Jacobians by rotations stay linearized here for as
  // long as the clone lives (first-estimate Jacobians).
  Eigen::Vector3d first_position_in_local = Eigen::Vector3d::Zero();
};

// A tracked point that stays in the state as long as it is in view.
struct StatePoint {
  uint64_t track_id = 0;
  int anchor = 0;               // Clone whose IMU frame holds the chart.
  PointChart chart;             // Made for the point's first estimate.
  Eigen::Vector3d coordinates;  // Present estimate, in the chart.
  bool contradicted = false;    // The newest observation contradicts the state.
};

// The position of a state point and its derivatives by the state. The derivatives are evaluated at
// the point's first estimate, which moves with the anchor. If each observation had its own
// linearization point, the observations together would seem to observe the scale of the motion,
// which no observation observes.
struct LocatedPoint {
  Eigen::Vector3d x_in_local;
  Eigen::Vector3d first_x_in_local;
  Eigen::Matrix<double, kPointDim, kCloneDim> by_anchor;
  Eigen::Matrix3d by_coordinates;
};

// Three rows that a track contributes about its point: by_point * (error of the point) +
// clones.jacobian * (error of the state at clones.blocks) + noise = clones.residual. The noise is
// white.
struct PointRows {
  Eigen::Vector3d x_in_local;  // Linearization point.
  Eigen::Matrix3d by_point;    // Upper triangular.
  Measurement clones;
};

// How the camera is mounted on the IMU.
struct Rig {
  Rigid3d cam_from_imu;
  double time_offset_s = 0.0;  // IMU time minus camera time, for the same instant.
};

struct FilterStateOptions {
  // Prior standard deviations of the rig. 0: the value is exact and not estimated.
  double extrinsic_rotation_sigma_rad = 0.0;
  double extrinsic_translation_sigma_m = 0.0;
  double time_offset_sigma_s = 0.0;
  // Standard deviation per axis of an offset that all landmarks of one tile share. 0: no such
  // offset. The filter never corrects the offset; it only accounts for its uncertainty (Schmidt).
  double tile_sigma_m = 0.0;
  // Most tracked points that stay in the state while in view, in [0, kMaxPoints]. 0: none.
  int max_points = 30;

  void Validate() const;
};

// The change that a measurement will make to the state.
struct Correction {
  Eigen::VectorXd error;  // Added to the mean.
  Eigen::MatrixXd gain;   // The covariance loses gain' gain, except for the tiles' offsets.
};

// Has a fixed size: a call allocates at most in proportion to its measurement. Not thread-safe.
class FilterState {
 public:
  // `covariance` is the covariance of `imu`.
  FilterState(const ImuState& imu, const Matrix15d& covariance, const Rig& rig,
              const FilterStateOptions& options);

  const ImuState& imu() const { return mean_.imu; }
  const FirstEstimate& first() const { return first_; }
  const Rig& rig() const { return mean_.rig; }
  // Null until InitializeGlobal succeeds.
  const std::optional<Rigid3d>& global_from_local() const { return mean_.global_from_local; }
  const std::vector<Clone>& clones() const { return mean_.clones; }  // Ordered by time.

  int dim() const { return clones_idx_ + kCloneDim * static_cast<int>(mean_.clones.size()); }
  int CloneIdx(int clone) const { return clones_idx_ + kCloneDim * clone; }
  bool estimates_rig() const { return estimates_rig_; }
  auto covariance() const { return covariance_.topLeftCorner(dim(), dim()); }

  // Moves the IMU to `end`. `first` and `transition` are the results of cairn::fusion::Propagate().
  void Propagate(const ImuState& end, const FirstEstimate& first, const ImuTransition& transition);

  // Adds a clone of the present pose, at which the camera took a frame (stochastic cloning).
  // `imu_rate_rad_s` is the bias-free angular rate; the time offset needs it. There must be fewer
  // than kMaxClones clones.
  void AddClone(int64_t frame_id, int64_t timestamp_ns, const Eigen::Vector3d& imu_rate_rad_s);

  // Marginalizes a clone. Points anchored at that clone move to the newest other clone.
  void RemoveClone(int clone);

  // Returns the offset of the tile's block in the error state. The first call for a tile makes the
  // block and replaces the least recently used tile if all are taken. Requires tile_sigma_m > 0.
  int TileIdx(uint64_t tile_id);
  // Returns the same offset, or nullopt if the tile has no block.
  std::optional<int> FindTileIdx(uint64_t tile_id) const;
  bool has_tiles() const { return tile_sigma_m_ > 0.0; }
  double tile_sigma_m() const { return tile_sigma_m_; }

  // Indexed by slot; null in free slots.
  const std::vector<std::optional<StatePoint>>& points() const { return mean_.points; }
  int PointIdx(int slot) const { return points_idx_ + kPointDim * slot; }

  LocatedPoint Locate(int slot) const;

  // Adds a point to a free slot, with exact correlations, anchored at the newest clone. Returns
  // false and changes nothing if the rows do not determine the point.
  bool EnterPoint(int slot, uint64_t track_id, const PointRows& rows);

  // Frees a slot.
  void RemovePoint(int slot);

  void SetContradicted(int slot, bool contradicted) {
    mean_.points[static_cast<size_t>(slot)]->contradicted = contradicted;
  }

  // Returns the squared Mahalanobis distance of the residual.
  double SquaredMahalanobis(const Measurement& measurement) const;

  // Kalman update. Does not correct the tiles' offsets but accounts for their uncertainty. Returns
  // false and changes nothing if the innovation covariance is not finite and positive definite.
  bool Update(const Measurement& measurement) { return Update({&measurement, 1}); }
  // Applies the rows of all parts as one measurement. Each part touches only its own blocks.
  bool Update(std::span<const Measurement> parts);

  // The two steps of Update. Solve returns nullopt if the innovation covariance is not finite and
  // positive definite.
  std::optional<Correction> Solve(std::span<const Measurement> parts) const;
  void Apply(const Correction& correction);

  // Kalman update with the measurement that `linearize(*this)` returns (a Measurement, compressed
  // or not). If the correction exceeds 2 cm or 3 mrad at some clone, the linearization is in doubt.
  // The measurement is then linearized again at the corrected state, at most twice: an iterated
  // Kalman update (Bell and Cathey 1993). Returns the same value as Update.
  template <typename Linearize>
  bool IteratedUpdate(const Linearize& linearize);

  // Sets global_from_local from a measurement that was linearized at `global_from_local` and whose
  // first block is {kGlobalIdx, num_global_dims}. Rows beyond those that determine the transform
  // update the state. The correlations with the measured clones and tiles are exact. Returns false
  // and leaves the filter unaligned if the measurement does not determine the transform.
  bool InitializeGlobal(const Rigid3d& global_from_local, const Measurement& measurement);

  void ForgetGlobal();

 private:
  struct Mean {
    ImuState imu;
    Rig rig;
    std::optional<Rigid3d> global_from_local;
    std::vector<Clone> clones;
    std::vector<std::optional<StatePoint>> points;
  };

  // Returns P H', the covariance between the whole state and the rows.
  Eigen::MatrixXd StateByRows(std::span<const Measurement> parts) const;
  static Eigen::MatrixXd InnovationCovariance(std::span<const Measurement> parts,
                                              const Eigen::MatrixXd& state_by_rows);
  void MoveMean(const Eigen::VectorXd& error);
  LocatedPoint Locate(const StatePoint& point) const;
  // Sets a point's anchor together with its first and its present estimate.
  void SetAnchor(int clone, const Eigen::Vector3d& first_x_in_local,
                 const Eigen::Vector3d& x_in_local, StatePoint* point) const;
  // Moves the anchor of the point in `slot` to `clone`.
  void MoveAnchor(int slot, int clone);
  // Returns the largest correction of a clone, relative to the limits beyond which the
  // linearization is in doubt.
  double LinearizationDoubt(const Eigen::VectorXd& error) const;
  // Enters a variable g at `offset`, for which `top` states by_variable * g + H x + n = r. Returns
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
    // Refers the residual to the prior mean again: r + H (x - x_prior).
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
