// Minimal problem: the relative pose of two calibrated cameras from five points.
#ifndef CAIRN_MAPPING_MATCHING_FIVE_POINT_H_
#define CAIRN_MAPPING_MATCHING_FIVE_POINT_H_

#include <Eigen/Core>
#include <array>

namespace cairn {

inline constexpr int kMaxEssentials = 10;

// Finds the essential matrices E with b[i]' E a[i] = 0 for five pairs of unit rays (Stewenius,
// Engels, Nister, "Recent developments on direct relative orientation", 2006). Returns their
// number, 0 to 10. Their norm is 1. Solutions are exact up to rounding. Returns 0 if the rays do
// not determine E up to a finite number of solutions.
//
// E lies in the null space of the five equations, E = x X + y Y + z Z + W. The cubic constraints
// det E = 0 and 2 E E' E - tr(E E') E = 0 give ten equations in 20 monomials. Elimination leaves
// the action matrix of the multiplication by x, whose real eigenvectors are the solutions.
int SolveFivePoint(const std::array<Eigen::Vector3d, 5>& a, const std::array<Eigen::Vector3d, 5>& b,
                   std::array<Eigen::Matrix3d, kMaxEssentials>* essentials);

}  // namespace cairn

#endif  // CAIRN_MAPPING_MATCHING_FIVE_POINT_H_
