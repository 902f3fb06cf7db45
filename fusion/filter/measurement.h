// Linearised measurements and their compression by orthogonal transformations.
#ifndef CAIRN_FUSION_FILTER_MEASUREMENT_H_
#define CAIRN_FUSION_FILTER_MEASUREMENT_H_

#include <Eigen/Core>
#include <vector>

namespace cairn::fusion {

// `size` neighbouring entries of the error state from `offset` on.
struct StateBlock {
  int offset = 0;
  int size = 0;

  bool operator==(const StateBlock&) const = default;
};

// residual = jacobian * (error of the state at `blocks`, in their order) + noise, the noise white
// with unit variance: whoever forms a measurement divides by its standard deviation first.
struct Measurement {
  std::vector<StateBlock> blocks;
  Eigen::MatrixXd jacobian;  // num_rows x (sum of the blocks' sizes).
  Eigen::VectorXd residual;  // Measured minus predicted.

  int num_rows() const { return static_cast<int>(residual.size()); }
};

// Applies Householder reflections to the rows of `rows` until its first `num_columns` columns are
// upper triangular. As the reflections are orthogonal, white noise on the rows stays white.
// - With the Jacobian of a variable to be eliminated in the leading columns, the rows below the
//   triangle are the projection of the others on its left nullspace.
// - With all of a Jacobian leading and the residual in the last column, the rows of the triangle
//   hold everything the measurement says about the state (paper, "Global Updates to the Local State
//   Estimation", measurement compression).
void Triangularize(int num_columns, Eigen::Ref<Eigen::MatrixXd> rows);

// Replaces a measurement of more rows than columns by an equivalent one of as many rows as columns.
void Compress(Measurement* measurement);

}  // namespace cairn::fusion

#endif  // CAIRN_FUSION_FILTER_MEASUREMENT_H_
