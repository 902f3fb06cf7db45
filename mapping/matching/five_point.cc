#include "mapping/matching/five_point.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>

namespace cairn {
namespace {

// Polynomials in x, y, z by the powers of their monomials.
//   Linear:    x, y, z, 1
//   Quadratic: x2, xy, y2, xz, yz, z2, x, y, z, 1
//   Cubic:     x3, x2y, xy2, y3, x2z, xyz, y2z, xz2, yz2, z3, then the quadratic ones
using Linear = Eigen::Matrix<double, 1, 4>;
using Quadratic = Eigen::Matrix<double, 1, 10>;
using Cubic = Eigen::Matrix<double, 1, 20>;

constexpr int kQuadraticOf[4][4] = {{0, 1, 3, 6}, {1, 2, 4, 7}, {3, 4, 5, 8}, {6, 7, 8, 9}};
constexpr int kCubicOf[10][4] = {
    {0, 1, 4, 10}, {1, 2, 5, 11},    {2, 3, 6, 12},    {4, 5, 7, 13},    {5, 6, 8, 14},
    {7, 8, 9, 15}, {10, 11, 13, 16}, {11, 12, 14, 17}, {13, 14, 15, 18}, {16, 17, 18, 19}};

// Not inlined: thirty unrolled copies would take two minutes to compile.
__attribute__((noinline)) Quadratic Times(const Linear& p, const Linear& q) {
  Quadratic product = Quadratic::Zero();
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) {
      product[kQuadraticOf[i][j]] += p[i] * q[j];
    }
  }
  return product;
}

__attribute__((noinline)) Cubic Times(const Quadratic& p, const Linear& q) {
  Cubic product = Cubic::Zero();
  for (int i = 0; i < 10; ++i) {
    for (int j = 0; j < 4; ++j) {
      product[kCubicOf[i][j]] += p[i] * q[j];
    }
  }
  return product;
}

// The entries of E as linear polynomials.
using LinearMatrix = std::array<std::array<Linear, 3>, 3>;

Cubic Determinant(const LinearMatrix& e) {
  const auto minor = [&](int c, int d) {
    return Quadratic(Times(e[1][c], e[2][d]) - Times(e[1][d], e[2][c]));
  };
  return Times(minor(1, 2), e[0][0]) - Times(minor(0, 2), e[0][1]) + Times(minor(0, 1), e[0][2]);
}

Eigen::Matrix<double, 10, 20> Constraints(const LinearMatrix& e) {
  std::array<std::array<Quadratic, 3>, 3> squared;  // E E' - tr(E E') / 2.
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      squared[i][j] = Times(e[i][0], e[j][0]) + Times(e[i][1], e[j][1]) + Times(e[i][2], e[j][2]);
    }
  }
  const Quadratic half_trace = 0.5 * (squared[0][0] + squared[1][1] + squared[2][2]);
  for (int i = 0; i < 3; ++i) {
    squared[i][i] -= half_trace;
  }
  Eigen::Matrix<double, 10, 20> constraints;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      constraints.row(3 * i + j) = Times(squared[i][0], e[0][j]) + Times(squared[i][1], e[1][j]) +
                                   Times(squared[i][2], e[2][j]);
    }
  }
  constraints.row(9) = Determinant(e);
  return constraints;
}

// The columns are X, Y, Z and W, row-major.
Eigen::Matrix<double, 9, 4> NullSpace(const std::array<Eigen::Vector3d, 5>& a,
                                      const std::array<Eigen::Vector3d, 5>& b) {
  Eigen::Matrix<double, 9, 5> equations;
  for (int i = 0; i < 5; ++i) {
    for (int row = 0; row < 3; ++row) {
      equations.block<3, 1>(3 * row, i) = b[i][row] * a[i];
    }
  }
  // Sizes known only at run time: unrolled for 9 and 10, these decompositions take a minute to
  // compile.
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr{Eigen::MatrixXd(equations)};
  const Eigen::MatrixXd q = qr.householderQ();
  return q.rightCols<4>();
}

}  // namespace

int SolveFivePoint(const std::array<Eigen::Vector3d, 5>& a, const std::array<Eigen::Vector3d, 5>& b,
                   std::array<Eigen::Matrix3d, kMaxEssentials>* essentials) {
  const Eigen::Matrix<double, 9, 4> basis = NullSpace(a, b);
  LinearMatrix e;
  for (int i = 0; i < 9; ++i) {
    e[i / 3][i % 3] = basis.row(i);
  }
  const Eigen::Matrix<double, 10, 20> constraints = Constraints(e);
  const Eigen::PartialPivLU<Eigen::MatrixXd> lu{Eigen::MatrixXd(constraints.leftCols<10>())};
  const Eigen::MatrixXd reduced = lu.solve(Eigen::MatrixXd(constraints.rightCols<10>()));
  if (!reduced.allFinite()) {
    return 0;
  }
  // Row i: x times the i-th quadratic monomial.
  Eigen::MatrixXd action = Eigen::MatrixXd::Zero(10, 10);
  constexpr int kCubicRows[6] = {0, 1, 2, 4, 5, 7};
  for (int i = 0; i < 6; ++i) {
    action.row(i) = -reduced.row(kCubicRows[i]);
  }
  action(6, 0) = action(7, 1) = action(8, 3) = action(9, 6) = 1.0;

  const Eigen::EigenSolver<Eigen::MatrixXd> solver(action);
  if (solver.info() != Eigen::Success) {
    return 0;
  }
  int count = 0;
  for (int i = 0; i < kMaxEssentials; ++i) {
    if (solver.eigenvalues()[i].imag() != 0.0) {
      continue;
    }
    const Eigen::Matrix<double, 10, 1> monomials = solver.eigenvectors().col(i).real();
    const Eigen::Vector4d weights = monomials.tail<4>();
    const Eigen::Matrix<double, 9, 1> flat = (basis * weights).normalized();
    if (flat.allFinite()) {
      (*essentials)[count++] =
          Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(flat.data());
    }
  }
  return count;
}

}  // namespace cairn
