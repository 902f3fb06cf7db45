#include "fusion/filter/measurement.h"

#include <Eigen/Householder>
#include <Eigen/QR>
#include <algorithm>

namespace cairn::fusion {

void Triangularize(int num_columns, Eigen::Ref<Eigen::MatrixXd> rows) {
  const int num_rows = static_cast<int>(rows.rows());
  const int width = static_cast<int>(rows.cols());
  // Few columns remain to the right of each reflected column, so each gets its own product.
  Eigen::VectorXd essential(num_rows);
  Eigen::RowVectorXd workspace(width);
  for (int j = 0; j < std::min(num_columns, num_rows - 1); ++j) {
    const int below = num_rows - j;
    double tau = 0.0;
    double beta = 0.0;
    auto tail = essential.head(below - 1);
    rows.col(j).tail(below).makeHouseholder(tail, tau, beta);
    rows.bottomRightCorner(below, width - j - 1)
        .applyHouseholderOnTheLeft(tail, tau, workspace.data());
    rows(j, j) = beta;
    rows.col(j).tail(below - 1).setZero();
  }
}

void Compress(Measurement* measurement) {
  const Eigen::Index num_columns = measurement->jacobian.cols();
  if (measurement->jacobian.rows() <= num_columns) {
    return;
  }
  const Eigen::HouseholderQR<Eigen::Ref<Eigen::MatrixXd>> qr(measurement->jacobian);
  measurement->residual.applyOnTheLeft(qr.householderQ().adjoint());
  measurement->residual.conservativeResize(num_columns);
  const Eigen::MatrixXd triangle =
      qr.matrixQR().topRows(num_columns).triangularView<Eigen::Upper>();
  measurement->jacobian = triangle;
}

}  // namespace cairn::fusion
