// How a session bends to fit the map: a smooth field of small motions.
#ifndef CAIRN_INGEST_ANCHOR_BENDING_H_
#define CAIRN_INGEST_ANCHOR_BENDING_H_

#include <Eigen/Core>
#include <vector>

#include "core/rigid3.h"
#include "ingest/anchor/pose_pair.h"

namespace cairn {

// A field of vectors over places in space; zero far from all that is known.
// docs/math/mapping_sessions.md.
class DriftField {
 public:
  DriftField() = default;  // Zero everywhere.

  // Finds the most likely field that explains `values` (3 numbers at each of `places`, whose
  // standard deviations an axis are `sigmas`) as a drift that varies over some distance, or no
  // field unless one explains them much better. `unit` is the magnitude of the smallest drift that
  // is looked for. Values that contradict their neighbors count less. Deterministic.
  static DriftField Fit(const std::vector<Eigen::Vector3d>& places,
                        const std::vector<Eigen::Vector3d>& values,
                        const std::vector<double>& sigmas, double unit);

  bool is_zero() const { return places_.empty(); }
  Eigen::Vector3d At(const Eigen::Vector3d& place) const;
  double amplitude() const { return amplitude_; }  // Standard deviation an axis.
  double wave_m() const { return wave_m_; }        // The distance over which it varies.
  // What each value differs by from the field that the others tell. Empty if the field is zero.
  const std::vector<Eigen::Vector3d>& surprises() const { return surprises_; }

 private:
  double amplitude_ = 0.0, wave_m_ = 1.0;
  std::vector<Eigen::Vector3d> places_, weights_, surprises_;
};

// What remains between a session and the map after one motion of the whole session.
class Bending {
 public:
  Bending() = default;  // None.

  // `pairs` are photos on which the map can be trusted; of each, cam_from_ecef is the pose by the
  // session after its motion.
  static Bending Fit(const std::vector<PosePair>& pairs);

  bool is_none() const { return shift_.is_zero() && turn_.is_zero(); }
  const DriftField& shift() const { return shift_; }  // Meters, ECEF.
  const DriftField& turn() const { return turn_; }    // Rotation vectors, ECEF, radians.

  Rigid3d Bend(const Rigid3d& cam_from_ecef) const;

 private:
  DriftField shift_, turn_;
};

}  // namespace cairn

#endif  // CAIRN_INGEST_ANCHOR_BENDING_H_
