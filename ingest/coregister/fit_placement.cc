#include "ingest/coregister/fit_placement.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/check.h"

namespace cairn {
namespace {

constexpr int kNumRounds = 12;
constexpr double kPositionSigmaM = 0.1;
constexpr double kRotationSigmaRad = 0.005;
// GPS receivers of phones tell the size of a street this well. A few cameras close together say
// nothing of it.
constexpr double kScaleSigma = 0.03;

using Vector7d = Eigen::Matrix<double, 7, 1>;

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

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

}  // namespace

PlacementFit FitPlacement(const std::vector<PosePair>& pairs, const PlacementFitOptions& options) {
  CAIRN_CHECK(!pairs.empty(), "a fit needs a camera");
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const PosePair& pair : pairs) {
    middle += pair.cam_from_ecef.Inverse().translation;
  }
  middle /= static_cast<double>(pairs.size());
  const std::vector<Difference> differences = DifferencesOf(pairs, middle);
  Vector7d x = MedianMotion(differences);
  for (int round = 0; round < kNumRounds; ++round) {
    x = Refine(differences, x);
  }

  PlacementFit fit;
  const Eigen::Quaterniond rotation = ExpSo3(x.head<3>());
  fit.scale = 1.0 + x(6);
  fit.map_from_session = {fit.scale, rotation,
                          middle + x.segment<3>(3) - fit.scale * (rotation * middle)};
  fit.moved_m = x.segment<3>(3).norm();
  fit.turned_rad = x.head<3>().norm();
  std::vector<double> residuals_m;
  for (const Difference& difference : differences) {
    const double residual_m = difference.PositionResidual(x).norm();
    if (residual_m <= options.max_residual_m &&
        difference.RotationResidual(x).norm() <= options.max_residual_rad) {
      residuals_m.push_back(residual_m);
    }
  }
  fit.num_agreeing = static_cast<int>(residuals_m.size());
  fit.median_residual_m = residuals_m.empty() ? 0.0 : Median(std::move(residuals_m));
  return fit;
}

}  // namespace cairn
