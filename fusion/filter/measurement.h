// Linearized measurements and their compression by orthogonal transformations.
#ifndef CAIRN_FUSION_FILTER_MEASUREMENT_H_
#define CAIRN_FUSION_FILTER_MEASUREMENT_H_

#include <Eigen/Core>
#include <vector>

namespace cairn::fusion {

// `size` adjacent entries of the error state, starting at `offset`.
struct StateBlock {
  int offset = 0;
  int size = 0;

  bool operator==(const StateBlock&) const = default;
};

// residual = jacobian * (error of the state at `blocks`, in their order) + noise. The noise is
// white with unit variance: the code that forms a measurement divides by the standard deviation
// first.
struct Measurement {
  std::vector<StateBlock> blocks;
  Eigen::MatrixXd jacobian;  // num_rows x (sum of the blocks' sizes).
  Eigen::VectorXd residual;  // Measured minus predicted.

  int num_rows() const { return static_cast<int>(residual.size()); }
};

// Applies Householder reflections to the rows of `rows` until the first `num_columns` columns are
// upper triangular. The reflections are orthogonal, so white noise on the rows stays white. Two
// uses:
// - Eliminating a variable: with the variable's Jacobian in the leading columns, the rows below the
//   triangle are the projection of the other columns onto its left nullspace.
// - Compressing a measurement: with a whole Jacobian leading and the residual in the last column,
//   the rows of the triangle hold everything that the measurement says about the state (paper,
//   "Global Updates to the Local State Estimation", measurement compression).
void Triangularize(int num_columns, Eigen::Ref<Eigen::MatrixXd> rows);

// If a measurement has more rows than columns, replaces it by an equivalent one with as many rows
// as columns.
void Compress(Measurement* measurement);

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_FILTER_MEASUREMENT_H_
