#include "ingest/place/fit_placement.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/check.h"
#include "core/geodesy.h"
#include "core/statistics.h"
#include "ingest/place/in_map_accuracy.h"

namespace cairn {
namespace {

constexpr int kNumRounds = 12;
constexpr double kPositionSigmaM = 0.1;
constexpr double kRotationSigmaRad = 0.005;
// GPS receivers of phones tell the size of a street this well. A few cameras close together say
// nothing of it.
constexpr double kScaleSigma = 0.03;

using Vector7d = Eigen::Matrix<double, 7, 1>;

// One camera's difference, about the middle of all cameras.
struct Difference {
  Eigen::Vector3d offset_m;    // From the middle, in the session.
  Eigen::Vector3d moved_m;     // Map minus session.
  Eigen::Vector3d turned_rad;  // Rotation vector of ecef_from_cam, map after session.

  // What is left after rotation w, translation t and change of size s: (w, t, s).
  Eigen::Vector3d PositionResidual(const Vector7d& x) const {
    return moved_m - (x.head<3>().cross(offset_m) + x.segment<3>(3) + x(6) * offset_m);
  }
  Eigen::Vector3d RotationResidual(const Vector7d& x) const { return turned_rad - x.head<3>(); }
};

std::vector<Difference> DifferencesOf(const std::vector<PosePair>& pairs,
                                      const Eigen::Vector3d& middle) {
  std::vector<Difference> differences;
  for (const PosePair& pair : pairs) {
    const Rigid3d ecef_from_cam = pair.cam_from_ecef.Inverse();
    const Rigid3d in_map = pair.cam_from_ecef_in_map.Inverse();
    const Eigen::Quaterniond turn = in_map.rotation * ecef_from_cam.rotation.conjugate();
    const Eigen::AngleAxisd angle_axis(turn);
    differences.push_back({ecef_from_cam.translation - middle,
                           in_map.translation - ecef_from_cam.translation,
                           angle_axis.angle() * angle_axis.axis()});
  }
  return differences;
}

// Componentwise medians: a start that half of the cameras cannot spoil.
Vector7d MedianMotion(const std::vector<Difference>& differences) {
  Vector7d x = Vector7d::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> moved, turned;
    for (const Difference& difference : differences) {
      moved.push_back(difference.moved_m[axis]);
      turned.push_back(difference.turned_rad[axis]);
    }
    x[axis] = Median(std::move(turned));
    x[3 + axis] = Median(std::move(moved));
  }
  return x;
}

// One round of iteratively reweighted least squares with the weights of Geman and McClure: cameras
// far off count for nothing.
Vector7d Refine(const std::vector<Difference>& differences, const Vector7d& x) {
  std::vector<double> errors;
  for (const Difference& difference : differences) {
    errors.push_back(std::hypot(difference.PositionResidual(x).norm() / kPositionSigmaM,
                                difference.RotationResidual(x).norm() / kRotationSigmaRad));
  }
  const double bend = std::max(4.0, 2.0 * Median(errors));
  Eigen::Matrix<double, 7, 7> information = Eigen::Matrix<double, 7, 7>::Zero();
  Vector7d right = Vector7d::Zero();
  information(6, 6) = 1.0 / (kScaleSigma * kScaleSigma);
  for (size_t i = 0; i < differences.size(); ++i) {
    const double bends = errors[i] / bend;
    const double weight = 1.0 / ((1.0 + bends * bends) * (1.0 + bends * bends));
    Eigen::Matrix<double, 6, 7> jacobian = Eigen::Matrix<double, 6, 7>::Zero();
    const Eigen::Vector3d& offset = differences[i].offset_m;
    jacobian.block<3, 3>(0, 0) = -Skew(offset) / kPositionSigmaM;
    jacobian.block<3, 3>(0, 3) = Eigen::Matrix3d::Identity() / kPositionSigmaM;
    jacobian.block<3, 1>(0, 6) = offset / kPositionSigmaM;
    jacobian.block<3, 3>(3, 0) = Eigen::Matrix3d::Identity() / kRotationSigmaRad;
    Eigen::Matrix<double, 6, 1> measured;
    measured << differences[i].moved_m / kPositionSigmaM,
        differences[i].turned_rad / kRotationSigmaRad;
    information += weight * jacobian.transpose() * jacobian;
    right += weight * jacobian.transpose() * measured;
  }
  // A line of cameras leaves no direction open, since their orientations count, too.
  return information.ldlt().solve(right);
}

Eigen::Vector3d MiddleOf(const std::vector<PosePair>& pairs) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const PosePair& pair : pairs) {
    middle += pair.cam_from_ecef.Inverse().translation;
  }
  return middle / static_cast<double>(pairs.size());
}

std::vector<PosePair> MovedBy(const Sim3d& motion, std::vector<PosePair> pairs) {
  for (PosePair& pair : pairs) {
    pair.cam_from_ecef = CamFromTarget(pair.cam_from_ecef, motion);
  }
  return pairs;
}

// The motion of the cameras, and the small motion that refines it once the cameras are moved.
struct RefinedMotion {
  Sim3d motion;                         // All of it.
  std::vector<Difference> differences;  // Before the last small motion.
  Vector7d x;                           // The last small motion.
};

RefinedMotion RefineFrom(const Sim3d& start, const std::vector<PosePair>& pairs) {
  // Rotations are linearized. A rotation by more changes positions 50 m away by more than 1 cm.
  constexpr double kMaxLinearRad = 0.02;
  constexpr int kMaxSteps = 5;
  RefinedMotion refined;
  refined.motion = start;
  for (int step = 0; step < kMaxSteps; ++step) {
    const std::vector<PosePair> moved = MovedBy(refined.motion, pairs);
    const Eigen::Vector3d middle = MiddleOf(moved);
    refined.differences = DifferencesOf(moved, middle);
    refined.x = MedianMotion(refined.differences);
    for (int round = 0; round < kNumRounds; ++round) {
      refined.x = Refine(refined.differences, refined.x);
    }
    const Eigen::Quaterniond rotation = ExpSo3(refined.x.head<3>());
    const double scale = 1.0 + refined.x(6);
    const Sim3d change{scale, rotation,
                       middle + refined.x.segment<3>(3) - scale * (rotation * middle)};
    refined.motion = change * refined.motion;
    if (refined.x.head<3>().norm() <= kMaxLinearRad) {
      break;
    }
  }
  return refined;
}

PlacementFit FitFrom(const Sim3d& start, const std::vector<PosePair>& pairs,
                     const PlacementFitOptions& options) {
  const RefinedMotion refined = RefineFrom(start, pairs);
  const Eigen::Vector3d middle = MiddleOf(pairs);
  const Eigen::Vector3d moved = refined.motion * middle - middle;
  PlacementFit fit;
  fit.map_from_session = refined.motion;
  fit.scale = refined.motion.scale;
  fit.moved_m = moved.norm();
  fit.raised_m =
      moved.dot(EcefFromEnu(GeodeticFromEcef(middle)).rotation * Eigen::Vector3d::UnitZ());
  fit.turned_rad = RotationAngleRad(refined.motion.rotation, Eigen::Quaterniond::Identity());
  std::vector<double> residuals_m;
  std::vector<PhotoDisagreement> photos;
  for (size_t i = 0; i < pairs.size(); ++i) {
    const Difference& difference = refined.differences[i];
    const double residual_m = difference.PositionResidual(refined.x).norm();
    fit.agrees.push_back(residual_m <= options.max_residual_m &&
                         difference.RotationResidual(refined.x).norm() <= options.max_residual_rad);
    if (fit.agrees.back()) {
      residuals_m.push_back(residual_m);
      photos.push_back({residual_m, pairs[i].accuracy_m});
    }
  }
  fit.disagreement_m = UnpredictedRadius68(photos);
  fit.num_agreeing = static_cast<int>(residuals_m.size());
  fit.median_residual_m = residuals_m.empty() ? 0.0 : Median(std::move(residuals_m));
  return fit;
}

// The size of the session by the map, from distances between cameras; 1 if they stand together.
double MedianScale(const std::vector<PosePair>& pairs) {
  constexpr double kLeastDistanceM = 5.0;
  std::vector<double> scales;
  for (size_t i = 0; i < pairs.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      const auto distance_m = [&](Rigid3d PosePair::*pose) {
        return ((pairs[i].*pose).Inverse().translation - (pairs[j].*pose).Inverse().translation)
            .norm();
      };
      const double in_session_m = distance_m(&PosePair::cam_from_ecef);
      if (in_session_m >= kLeastDistanceM) {
        scales.push_back(distance_m(&PosePair::cam_from_ecef_in_map) / in_session_m);
      }
    }
  }
  const double scale = scales.empty() ? 1.0 : Median(std::move(scales));
  return scale > 0.0 ? scale : 1.0;
}

// The motion of one camera.
Sim3d MotionOf(const PosePair& pair, double scale) {
  const Rigid3d ecef_from_cam = pair.cam_from_ecef.Inverse();
  const Rigid3d in_map = pair.cam_from_ecef_in_map.Inverse();
  const Eigen::Quaterniond rotation =
      (in_map.rotation * ecef_from_cam.rotation.conjugate()).normalized();
  return {scale, rotation, in_map.translation - scale * (rotation * ecef_from_cam.translation)};
}

// The number of cameras that the motion of one of them brings about to where the map has them.
int CountNear(const PosePair& start, double scale, const std::vector<PosePair>& pairs,
              const PlacementFitOptions& options) {
  // The orientation of one camera errs by about a degree, which turns the others about it.
  constexpr double kSlackRad = 0.02;
  const Sim3d motion = MotionOf(start, scale);
  const Eigen::Vector3d fixed = start.cam_from_ecef_in_map.Inverse().translation;
  int num_near = 0;
  for (const PosePair& pair : pairs) {
    const Rigid3d moved = CamFromTarget(pair.cam_from_ecef, motion).Inverse();
    const Rigid3d in_map = pair.cam_from_ecef_in_map.Inverse();
    const double off_m = (moved.translation - in_map.translation).norm();
    const double slack_m = kSlackRad * (in_map.translation - fixed).norm();
    num_near += off_m <= options.max_residual_m + slack_m &&
                RotationAngleRad(moved.rotation, in_map.rotation) <= options.max_residual_rad;
  }
  return num_near;
}

// The motion of a single camera on which most cameras agree.
Sim3d Consensus(const std::vector<PosePair>& pairs, const PlacementFitOptions& options) {
  Sim3d best;
  int most = -1;
  for (const double scale : {1.0, MedianScale(pairs)}) {
    for (const PosePair& pair : pairs) {
      const int num_near = CountNear(pair, scale, pairs, options);
      if (num_near > most) {
        most = num_near;
        best = MotionOf(pair, scale);
      }
    }
  }
  return best;
}

}  // namespace

PlacementFit FitPlacement(const std::vector<PosePair>& pairs, const PlacementFitOptions& options) {
  CAIRN_CHECK(!pairs.empty(), "a fit needs a camera");
  PlacementFit fit = FitFrom(Sim3d(), pairs, options);
  if (2 * fit.num_agreeing < static_cast<int>(pairs.size())) {
    PlacementFit other = FitFrom(Consensus(pairs, options), pairs, options);
    if (other.num_agreeing > fit.num_agreeing) {
      fit = std::move(other);
    }
  }
  return fit;
}

}  // namespace cairn
