#include "python/arrays.h"

#include <fmt/format.h>

namespace cairn::python {

std::string DescribeArray(const py::array& array) {
  return fmt::format("{} of shape {}", py::str(array.dtype()).cast<std::string>(),
                     py::str(array.attr("shape")).cast<std::string>());
}

py::array RequireArray(const std::string& argument, py::handle value) {
  if (!py::isinstance<py::array>(value)) {
    RefuseArgument(argument,
                   fmt::format("must be a numpy array, not {}", Py_TYPE(value.ptr())->tp_name));
  }
  const auto array = py::reinterpret_borrow<py::array>(value);
  // Not by `byteorder`, which may name this machine's order: '<' of h5py's arrays.
  if (!array.dtype().attr("isnative").cast<bool>()) {
    RefuseArgument(argument, fmt::format("{} has another byte order than this machine; pass "
                                         "{}.astype({}.dtype.newbyteorder('='))",
                                         DescribeArray(array), argument, argument));
  }
  if ((array.flags() & py::array::c_style) == 0) {
    RefuseArgument(argument,
                   fmt::format("the elements are not contiguous (strides {}); pass "
                               "numpy.ascontiguousarray({})",
                               py::str(array.attr("strides")).cast<std::string>(), argument));
  }
  return array;
}

std::vector<double> RowsOf(const std::string& argument, py::handle value, py::ssize_t num_columns,
                           py::ssize_t num_rows) {
  const py::array array = RequireArray(argument, value);
  if (!HoldsA<double>(array) || array.ndim() != 2 || array.shape(1) != num_columns ||
      (num_rows >= 0 && array.shape(0) != num_rows)) {
    RefuseArgument(argument,
                   fmt::format("{}; must be float64 of shape ({}, {})", DescribeArray(array),
                               num_rows >= 0 ? std::to_string(num_rows) : "N", num_columns));
  }
  const auto* data = static_cast<const double*>(array.data());
  return {data, data + array.size()};
}

py::array_t<double> ArrayOf(const Eigen::Ref<const Eigen::MatrixXd>& matrix) {
  py::array_t<double> array({matrix.rows(), matrix.cols()});
  Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
      array.mutable_data(), matrix.rows(), matrix.cols()) = matrix;
  return array;
}

py::array_t<double> VectorArrayOf(const Eigen::Vector3d& vector) {
  return py::array_t<double>(vector.size(), vector.data());
}

py::array_t<double> PoseArray(const Rigid3d& pose) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topRows<3>() = pose.ToMatrix();
  return ArrayOf(matrix);
}

}  // namespace cairn::python
